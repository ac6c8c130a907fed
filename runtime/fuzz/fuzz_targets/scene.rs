//! Scenes, with every check that needs no superelement.
#![no_main]

use dcb_formats_fuzz::{file, refused};
use dcb_formats::scene::Scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("scene.json", data);
    let read = Scene::read(&path).and_then(|scene| scene.check());
    if let Err(error) = read {
        refused(&error.to_string());
    }
});
