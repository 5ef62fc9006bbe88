use super::folder;
use prt_transfer::Error;
use prt_transfer::io::atomic::{self, AtomicFile};
use std::fs;
use std::io::{self, Write};

fn entries(folder: &std::path::Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = folder();
    let path = folder.path().join("T.npz");
    fs::write(&path, "old").unwrap();
    // More than any buffer holds before the disk says no.
    let full = |file: &mut dyn Write| {
        file.write_all(&[1; 1 << 20])?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    let error = atomic::write(&path, full).unwrap_err();
    assert!(matches!(&error, Error::Io { action: "write", path: p, .. } if *p == path), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(entries(folder.path()), ["T.npz"]);
}

#[test]
fn a_file_appears_only_when_it_is_committed() {
    let folder = folder();
    let path = folder.path().join("y.npy");
    let mut file = AtomicFile::create(&path).unwrap();
    file.put(b"half").unwrap();
    assert!(!path.exists());
    drop(file);
    assert!(entries(folder.path()).is_empty());
    atomic::write(&path, |file| file.write_all(b"whole")).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
    assert_eq!(entries(folder.path()), ["y.npy"]);
}

#[test]
fn a_missing_folder_is_named() {
    let folder = folder();
    let path = folder.path().join("nowhere/y.npy");
    super::names(atomic::write(&path, |_| Ok(())), "nowhere/y.npy");
    super::names(atomic::write(folder.path(), |_| Ok(())), "create");
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_an_ordinary_new_file_or_of_the_old_one() {
    use std::os::unix::fs::PermissionsExt;
    let mode = |path: &std::path::Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let folder = folder();
    let (ours, ordinary) = (folder.path().join("ours"), folder.path().join("ordinary"));
    atomic::write(&ours, |file| file.write_all(b"1")).unwrap();
    fs::write(&ordinary, "1").unwrap();
    assert_eq!(mode(&ours), mode(&ordinary));
    fs::set_permissions(&ours, PermissionsExt::from_mode(0o640)).unwrap();
    atomic::write(&ours, |file| file.write_all(b"2")).unwrap();
    assert_eq!(mode(&ours), 0o640);
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let folder = folder();
    let (target, link) = (folder.path().join("target"), folder.path().join("link"));
    fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    atomic::write(&link, |file| file.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&target).unwrap(), "new");
}

/// A device cannot be replaced: it must still be one afterwards, and say that it is full.
#[cfg(target_os = "linux")]
#[test]
fn a_device_is_written_in_place() {
    use std::os::unix::fs::FileTypeExt;
    let error = atomic::write("/dev/full", |file| file.write_all(&[0; 1 << 20])).unwrap_err();
    assert!(matches!(error, Error::Io { ref cause, .. } if cause.kind() == io::ErrorKind::StorageFull), "{error}");
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[test]
fn what_a_killed_process_left_goes_with_the_next_file_and_what_another_writes_stays() {
    let folder = tempfile::tempdir().unwrap();
    let [abandoned, foreign] = [".prt-abcdef.part", "prt-abcdef.part"].map(|name| folder.path().join(name));
    for path in [&abandoned, &foreign] {
        std::fs::write(path, "half").unwrap();
    }
    let mut other = AtomicFile::create(folder.path().join("other")).unwrap();
    other.put(b"other").unwrap();
    atomic::write(folder.path().join("whole"), |file| file.write_all(b"whole")).unwrap();
    assert!(!abandoned.exists() && foreign.exists());
    other.commit().unwrap();
    assert_eq!(std::fs::read(folder.path().join("other")).unwrap(), b"other");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}
