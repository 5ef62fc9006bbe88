#![no_main]
prt_fuzz::fuzz!("pca");
