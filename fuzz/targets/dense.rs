#![no_main]
prt_fuzz::fuzz!("dense");
