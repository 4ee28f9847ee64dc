//! Joins the crate's sources to one text: what a drawn case is compared by.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let here = env::var("CARGO_MANIFEST_DIR").map_err(io::Error::other)?;
    let out = env::var("OUT_DIR").map_err(io::Error::other)?;
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(&here)? {
        let path = entry?.path();
        if path.extension().is_some_and(|end| end == "rs") && !path.ends_with("build.rs") {
            files.push(path);
        }
    }
    files.sort();
    let mut whole = String::new();
    for file in &files {
        println!("cargo::rerun-if-changed={}", file.display());
        whole.push_str(&fs::read_to_string(file)?);
    }
    println!("cargo::rerun-if-changed={here}");
    fs::write(Path::new(&out).join("source.txt"), whole)
}
