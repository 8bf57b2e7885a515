#![no_main]

#[path = "../entries.rs"]
#[allow(dead_code, reason = "every target uses its own entry")]
mod entries;

libfuzzer_sys::fuzz_target!(|data: &[u8]| entries::gltf(data));
