#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| subsolid_fuzz::within_memory(data, subsolid_fuzz::checks::mesh));
