#![no_main]
prt_fuzz::fuzz!("f16");
