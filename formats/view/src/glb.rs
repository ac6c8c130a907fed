//! A binary glTF 2.0 file while it grows: numbers in one buffer, and how they are to be read.

use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index, Root};
use serde_json::json;

/// Scene and buffer.
#[derive(Default)]
pub struct Glb {
    /// All but the numbers.
    pub root: Root,
    bytes: Vec<u8>,
}

impl Glb {
    fn accessor(
        &mut self,
        bytes: &[u8],
        kind: (ComponentType, Type),
        count: usize,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(offset.into()),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        });
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: count.into(),
            component_type: Valid(GenericComponentType(kind.0)),
            extensions: None,
            extras: None,
            type_: Valid(kind.1),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    /// Values of an animation: `count` scalars, vectors or quaternions.
    pub fn reals(&mut self, values: &[f32], kind: Type, count: usize) -> Index<Accessor> {
        self.singles(values, kind, count, None)
    }

    fn singles(
        &mut self,
        values: &[f32],
        kind: Type,
        count: usize,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.accessor(&bytes, (ComponentType::F32, kind), count, target)
    }

    /// Times of an animation, ascending.
    pub fn times(&mut self, values: &[f32]) -> Index<Accessor> {
        let index = self.singles(values, Type::Scalar, values.len(), None);
        if let (Some(accessor), [first, .., last]) = (self.root.accessors.last_mut(), values) {
            accessor.min = Some(json!([first]));
            accessor.max = Some(json!([last]));
        }
        index
    }

    /// Places in the vectors of a mesh.
    pub fn places(&mut self, of: &[u32]) -> Index<Accessor> {
        let bytes: Vec<u8> = of.iter().flat_map(|place| place.to_le_bytes()).collect();
        let kind = (ComponentType::U32, Type::Scalar);
        self.accessor(&bytes, kind, of.len(), Some(Target::ElementArrayBuffer))
    }

    /// Vectors of a mesh, with the box round them, which positions must have.
    pub fn vectors(&mut self, of: &[[f64; 3]]) -> Index<Accessor> {
        let values: Vec<f32> = of.iter().flatten().map(|value| *value as f32).collect();
        let target = Some(Target::ArrayBuffer);
        let index = self.singles(&values, Type::Vec3, of.len(), target);
        let most = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| {
                let along = values.iter().skip(axis).step_by(3).copied();
                along.reduce(pick).unwrap_or(0.0)
            })
        };
        if let Some(accessor) = self.root.accessors.last_mut() {
            accessor.min = Some(json!(most(f32::min)));
            accessor.max = Some(json!(most(f32::max)));
        }
        index
    }

    /// Header, scene, buffer. `source` says what it was made from.
    ///
    /// # Errors
    /// A sentence about what can't be written.
    pub fn finish(mut self, generator: &str, source: &str) -> Result<Vec<u8>, String> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(gltf_json::Buffer {
            byte_length: self.bytes.len().into(),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        self.root.asset.generator = Some(generator.to_owned());
        self.root.asset.extras = extras(&json!({ "source": source }));
        let mut text = serde_json::to_vec(&self.root)
            .map_err(|error| format!("can't be written as JSON: {error}"))?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let sizes = [
            28 + text.len() + self.bytes.len(),
            text.len(),
            self.bytes.len(),
        ];
        let sizes = sizes.map(u32::try_from);
        let [Ok(all), Ok(of_text), Ok(of_bytes)] = sizes else {
            return Err("is too large for one glTF file (4 GiB)".to_owned());
        };
        let mut file = Vec::with_capacity(all as usize);
        file.extend(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend(all.to_le_bytes());
        for (size, kind, chunk) in [(of_text, b"JSON", text), (of_bytes, b"BIN\0", self.bytes)] {
            file.extend(size.to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        Ok(file)
    }
}

/// What glTF has no place for.
pub fn extras(value: &serde_json::Value) -> gltf_json::Extras {
    serde_json::value::RawValue::from_string(value.to_string()).ok()
}
