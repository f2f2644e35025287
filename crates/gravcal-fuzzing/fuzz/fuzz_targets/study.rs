#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gravcal_fuzzing::study(bytes));
