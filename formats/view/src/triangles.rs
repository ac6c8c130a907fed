//! Triangles of STL and OBJ files, which may come from strangers: sizes come before memory.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use dcb_formats::Error;

/// Largest file, bytes.
const LARGEST: u64 = 32 << 20;
/// Most triangles: a page stays small.
const MOST_TRIANGLES: usize = 60_000;
/// Bytes before the triangles of a binary STL file: a text and their number.
const STL_HEADER: usize = 84;
/// Bytes of a triangle: normal and corners in single precision, and two more.
const STL_TRIANGLE: usize = 50;

/// Triangles with their corners, each place once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Corners.
    pub positions: Vec<[f64; 3]>,
    /// Places in the positions, three a triangle.
    pub cells: Vec<u32>,
}

impl Triangles {
    /// Reads an STL file, binary or text, or an OBJ file; its name tells which.
    ///
    /// # Errors
    /// [`Error::Io`], and [`Error::File`] for what isn't such a file, has no triangles, or too many for a page.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let refused = |message: String| Error::File {
            path: path.to_owned(),
            message,
        };
        let file = File::open(path).map_err(|source| Error::io(path, "cannot read", source))?;
        let mut bytes = Vec::new();
        file.take(LARGEST + 1)
            .read_to_end(&mut bytes)
            .map_err(|source| Error::io(path, "cannot read", source))?;
        if bytes.len() as u64 > LARGEST {
            return Err(refused(format!(
                "has more than {} MiB; simplify it",
                LARGEST >> 20
            )));
        }
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let read = match ending.to_str() {
            Some("stl") => stl(&bytes),
            Some("obj") => text_of(&bytes).and_then(obj),
            _ => Err("is neither an .stl nor an .obj file".to_owned()),
        };
        let found = read.map_err(refused)?;
        if found.cells.is_empty() {
            return Err(refused("has no triangles".into()));
        }
        Ok(found)
    }

    fn add(&mut self, corners: [u32; 3]) -> Result<(), String> {
        if self.cells.len() >= 3 * MOST_TRIANGLES {
            return Err(format!(
                "has more than {MOST_TRIANGLES} triangles, too many for a page; simplify it"
            ));
        }
        self.cells.extend(corners);
        Ok(())
    }
}

fn text_of(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|error| format!("is not text ({error})"))
}

/// Corners, each place once.
#[derive(Default)]
struct Corners {
    found: Triangles,
    places: HashMap<[u32; 3], u32>,
}

impl Corners {
    fn triangle(&mut self, corners: [[f32; 3]; 3]) -> Result<(), String> {
        let mut numbers = [0; 3];
        for (number, corner) in numbers.iter_mut().zip(corners) {
            if corner.iter().any(|value| !value.is_finite()) {
                return Err("has a corner that isn't a finite number".into());
            }
            let positions = &mut self.found.positions;
            *number = *self
                .places
                .entry(corner.map(f32::to_bits))
                .or_insert_with(|| {
                    positions.push(corner.map(f64::from));
                    positions.len() as u32 - 1
                });
        }
        self.found.add(numbers)
    }
}

/// Text files start with `solid`, but some binary ones too: the size of a binary file follows from its number of triangles.
fn stl(bytes: &[u8]) -> Result<Triangles, String> {
    let claimed = bytes.get(STL_HEADER - 4..STL_HEADER);
    let claimed = claimed.and_then(|four| <[u8; 4]>::try_from(four).ok());
    let claimed = claimed.map(|four| u64::from(u32::from_le_bytes(four)));
    let size = claimed.map(|count| STL_HEADER as u64 + STL_TRIANGLE as u64 * count);
    if size == Some(bytes.len() as u64) {
        return stl_binary(bytes);
    }
    match (bytes.trim_ascii_start().starts_with(b"solid"), claimed) {
        (true, _) => stl_text(text_of(bytes)?),
        (false, Some(count)) => Err(format!(
            "has {} bytes, but its header tells of {count} triangles; it may be cut off",
            bytes.len()
        )),
        (false, None) => Err("is too short for an STL file".into()),
    }
}

fn stl_binary(bytes: &[u8]) -> Result<Triangles, String> {
    let mut corners = Corners::default();
    for triangle in bytes[STL_HEADER..].chunks_exact(STL_TRIANGLE) {
        let number = |index: usize| {
            let at = 12 + 4 * index;
            f32::from_le_bytes([0, 1, 2, 3].map(|byte| triangle[at + byte]))
        };
        corners.triangle([0, 3, 6].map(|first| [0, 1, 2].map(|axis| number(first + axis))))?;
    }
    Ok(corners.found)
}

fn stl_text(text: &str) -> Result<Triangles, String> {
    let mut corners = Corners::default();
    let mut of_facet: Vec<[f32; 3]> = Vec::new();
    for (line, words) in lines(text) {
        match words.first().copied() {
            Some("vertex") => of_facet.push(numbers(line, &words)?.map(|value| value as f32)),
            Some("endfacet") => {
                let facet = <[[f32; 3]; 3]>::try_from(of_facet.as_slice());
                let facet = facet.map_err(|_| {
                    format!(
                        "line {line}: a facet with {} corners, expected 3",
                        of_facet.len()
                    )
                })?;
                corners.triangle(facet)?;
                of_facet.clear();
            }
            _ => {}
        }
        if of_facet.len() > 3 {
            return Err(format!("line {line}: a facet with more than 3 corners"));
        }
    }
    Ok(corners.found)
}

/// Vertices and faces; everything else of an OBJ file is for surfaces that look finer.
fn obj(text: &str) -> Result<Triangles, String> {
    let mut found = Triangles::default();
    for (line, words) in lines(text) {
        match words.first().copied() {
            Some("v") => found.positions.push(numbers(line, &words)?),
            Some("f") => {
                let count = found.positions.len();
                let corner = |word: &&str| {
                    corner(word, count).map_err(|told| format!("line {line}: {told}"))
                };
                let corners: Vec<u32> = words[1..].iter().map(corner).collect::<Result<_, _>>()?;
                for pair in corners.get(1..).unwrap_or_default().windows(2) {
                    found.add([corners[0], pair[0], pair[1]])?;
                }
            }
            _ => {}
        }
    }
    Ok(found)
}

/// The vertex of `7`, `7/1`, `7//2` or `-1` (the last one).
fn corner(word: &str, count: usize) -> Result<u32, String> {
    let vertex = word.split('/').next().unwrap_or_default();
    let number: i64 = vertex
        .parse()
        .map_err(|_| format!("{word:?} is no number of a vertex"))?;
    let index = match number {
        number if number < 0 => count as i64 + number,
        number => number - 1,
    };
    match usize::try_from(index) {
        Ok(index) if index < count => Ok(index as u32),
        _ => Err(format!("vertex {number}, but there are {count} before")),
    }
}

/// Lines from 1, in words.
fn lines(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let lines = text.lines().enumerate();
    lines.map(|(index, line)| (index + 1, line.split_whitespace().collect()))
}

fn numbers(line: usize, words: &[&str]) -> Result<[f64; 3], String> {
    let mut values = [0.0; 3];
    for (axis, value) in values.iter_mut().enumerate() {
        let word = words.get(axis + 1).copied().unwrap_or_default();
        *value = match word.parse::<f64>() {
            Ok(number) if (number as f32).is_finite() => number,
            _ => return Err(format!("line {line}: {word:?} is no coordinate")),
        };
    }
    Ok(values)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 3.0, 0.0],
        [0.0, 0.0, 4.0],
    ];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    /// A sixth of the sum of det(a, b, c): the volume inside, whatever the order of places is.
    fn volume(of: &Triangles) -> f64 {
        let corner = |index: u32| nalgebra::Vector3::from(of.positions[index as usize]);
        let triangles = of
            .cells
            .chunks(3)
            .map(|cell| [0, 1, 2].map(|k| corner(cell[k])));
        triangles.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
    }

    fn binary() -> Vec<u8> {
        let mut bytes = b"solid but binary".to_vec();
        bytes.resize(80, 0);
        bytes.extend(4_u32.to_le_bytes());
        for face in FACES {
            bytes.extend([0; 12]);
            bytes.extend(
                face.iter()
                    .flat_map(|corner| CORNERS[*corner])
                    .flat_map(f32::to_le_bytes),
            );
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn files_of_all_kinds_have_the_volume_of_the_tetrahedron() {
        let facet = |face: [usize; 3]| {
            let vertices = face.map(|corner| {
                let [x, y, z] = CORNERS[corner];
                format!("vertex {x} {y} {z}\n")
            });
            format!(
                "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
                vertices.concat()
            )
        };
        let text = format!("solid tetra\n{}endsolid\n", FACES.map(facet).concat());
        let wavefront = "# a comment\nv 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1/1 3/1 2/1\nf 1 2 4\nf -3//1 -2//1 -1//1\nf 1 4 3\n";
        for found in [stl(&binary()), stl(text.as_bytes()), obj(wavefront)] {
            let found = found.unwrap();
            assert_eq!((found.positions.len(), found.cells.len()), (4, 12));
            assert!((volume(&found) - 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn hostile_files_are_refused() {
        let mut many = binary();
        many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        many[0] = b'x';
        assert!(stl(&many).unwrap_err().contains("4294967295 triangles"));
        assert!(stl(b"x").unwrap_err().contains("too short"));
        let mut infinite = binary();
        infinite[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert!(stl(&infinite).unwrap_err().contains("finite"));
        for (text, told) in [
            ("v 0 0 0\nf 1 2 3\n", "line 2: vertex 2, but there are 1"),
            ("f 0 0 0\n", "vertex 0"),
            (
                "f -9223372036854775808 1 1\n",
                "vertex -9223372036854775808",
            ),
            ("v 1 2\n", "line 1"),
            ("v 1 2 nan\n", "no coordinate"),
        ] {
            let found = obj(text).unwrap_err();
            assert!(found.contains(told), "{found}");
        }
        assert!(
            stl(b"solid\nfacet\nvertex 1 2 3\nendfacet\n")
                .unwrap_err()
                .contains("1 corners")
        );
        let wheel = format!(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n",
            " 1 2 3".repeat(MOST_TRIANGLES)
        );
        assert!(obj(&wheel).unwrap_err().contains("more than"));
    }
}
