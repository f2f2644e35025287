//! No command writes onto what it reads, nor two results onto one file, be it through links.

use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// Sees to it that none of the files that are written is one that is read, or another one that is written. What is read may be a folder
/// of files.
///
/// # Errors
/// Names the file.
pub fn check(reads: impl IntoIterator<Item = impl AsRef<Path>>, writes: &[PathBuf]) -> Result<(), Failure> {
    let read: Vec<Identity> =
        reads.into_iter().flat_map(|path| files_in(path.as_ref())).filter_map(|path| identity(&path)).collect();
    for (place, path) in writes.iter().enumerate() {
        if identity(path).is_some_and(|written| read.contains(&written)) {
            let message =
                format!("{}: this file is read, and would be replaced by what is made from it", path.display());
            return Err(Failure::said(message).hint("give what is written another name"));
        }
        if writes[..place].iter().any(|other| is_same(other, path)) {
            let message = format!("{}: two results would be written to this file", path.display());
            return Err(Failure::said(message).hint("give each of them a name of its own"));
        }
    }
    Ok(())
}

/// The file itself, or those in a folder of a recording.
fn files_in(path: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    std::iter::once(path.to_owned()).chain(entries.map(|entry| entry.path())).collect()
}

/// Whether two names are, or would be, one file.
fn is_same(a: &Path, b: &Path) -> bool {
    match (identity(a), identity(b)) {
        (Some(a), Some(b)) => a == b,
        (None, None) => a.file_name() == b.file_name() && identity(&folder_of(a)) == identity(&folder_of(b)),
        _ => false,
    }
}

fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new(".")).to_owned()
}

#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

/// What is the same however a file is named; `None` where there is none. Devices have no contents to lose.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    let metadata = fs::metadata(path).ok().filter(|metadata| metadata.is_file() || metadata.is_dir())?;
    Some((metadata.dev(), metadata.ino()))
}

/// What is the same however a file is named; `None` where there is none.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    path.canonicalize().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_not_written_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("bag")).unwrap();
        for name in ["session.toml", "bag/1.mcap", "other"] {
            fs::write(path(name), "").unwrap();
        }
        let reads = [path("session.toml"), path("bag"), path("absent")];
        let refused = |writes: &[&str]| {
            let writes: Vec<PathBuf> = writes.iter().map(|name| path(name)).collect();
            check(&reads, &writes).err().map(|failure| failure.to_string())
        };
        assert_eq!(refused(&["other", "new", "absent"]), None);
        for name in ["session.toml", "bag/../session.toml", "bag/1.mcap"] {
            let reported = refused(&["other", name]);
            assert!(
                reported.as_ref().is_some_and(|reported| reported.contains("this file is read")),
                "{name}: {reported:?}"
            );
        }
        for pair in [["new", "bag/../new"], ["other", "bag/../other"]] {
            assert!(refused(&pair).is_some_and(|reported| reported.contains("two results")), "{pair:?}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(path("session.toml"), path("link")).unwrap();
            fs::hard_link(path("bag/1.mcap"), path("hard")).unwrap();
            assert!(refused(&["link"]).is_some() && refused(&["hard"]).is_some());
        }
    }
}
