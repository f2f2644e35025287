//! A file is opened here only if it can be read from its beginning more than once.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Opens a file.
///
/// # Errors
///
/// It cannot be opened, or is no file: opening a pipe may wait for ever for who writes into it, what was read from it once is gone, and
/// some devices have no end.
pub(crate) fn opened(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    match found.is_file() {
        true => File::open(path),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, what_it_is(&found))),
    }
}

#[cfg(unix)]
fn what_it_is(found: &fs::Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = found.file_type();
    match () {
        () if kind.is_dir() => "it is a folder, and no file",
        () if kind.is_fifo() || kind.is_socket() => {
            "it is a pipe, and is read more than once: write what comes out of it to a file, and give that"
        }
        () => "it is a device, and no file",
    }
}

#[cfg(not(unix))]
fn what_it_is(_: &fs::Metadata) -> &'static str {
    "it is no file"
}

#[cfg(all(test, unix))]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::{Digest, Table, inspect, open};

    /// A pipe into which nobody writes: who opens it waits for ever.
    #[test]
    fn a_pipe_or_device_is_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.csv");
        if !Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()) {
            return; // where there is no mkfifo
        }
        for (path, expected) in
            [(pipe.as_path(), "it is a pipe"), (Path::new("/dev/zero"), "it is a device, and no file")]
        {
            let errors = [
                open(path).err().unwrap().to_string(),
                Table::read(path).unwrap_err().to_string(),
                inspect(path, &|_| {}).unwrap_err().to_string(),
            ];
            for error in errors {
                assert!(error.contains(expected) && error.contains(&path.display().to_string()), "{error}");
            }
            assert!(Digest::of(path).is_err());
        }
    }

    #[test]
    fn a_file_is_opened_also_through_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["a.csv", "b.csv"].map(|name| folder.path().join(name));
        fs::write(&file, "q,tau\n1,2\n").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert_eq!(Table::read(&link).unwrap().len(), 1);
        assert_eq!(opened(folder.path()).unwrap_err().to_string(), "it is a folder, and no file");
    }
}
