//! Reading a text file, with errors that say what to do.

use std::io;
use std::path::Path;

use gravcal_recording::{LARGEST_DOCUMENT, read_whole};

use super::file_error::FileError;

/// The text of a file.
///
/// # Errors
/// There is no such file or folder, it is a folder, a pipe or a device, it is larger than [`LARGEST_DOCUMENT`], the operating system
/// refuses, or it is not UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String, FileError> {
    let bytes = read_whole(path, LARGEST_DOCUMENT).map_err(|error| opening_error(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        FileError::new(path, "this is not UTF-8 text: save the file in UTF-8").at_line(line)
    })
}

/// What the operating system calls "not found" may be the file or its folder.
fn opening_error(path: &Path, error: &io::Error) -> FileError {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists());
    match (error.kind(), folder) {
        _ if path.is_dir() => FileError::new(path, "this is a folder: name a file in it"),
        (io::ErrorKind::NotFound, Some(folder)) => {
            FileError::new(path, format!("there is no such folder as {}", folder.display()))
        }
        (io::ErrorKind::NotFound, None) => FileError::new(path, "there is no such file"),
        _ => FileError::new(path, format!("cannot be read: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, File};
    use std::process::Command;

    use super::*;

    #[test]
    fn what_has_no_end_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| read_text(path).unwrap_err().to_string();
        let large = folder.path().join("large.toml");
        File::create(&large).unwrap().set_len(LARGEST_DOCUMENT + 1).unwrap();
        assert!(message(&large).ends_with("it holds more than 4194304 bytes, and no file of its kind does"));
        let pipe = folder.path().join("pipe.toml");
        if cfg!(unix) && Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()) {
            assert!(message(&pipe).contains("pipe.toml: cannot be read: it is a pipe"), "{}", message(&pipe));
            assert!(message(Path::new("/dev/zero")).ends_with("it is a device, and no file"));
        }
    }

    #[test]
    fn what_cannot_be_read_is_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        let message = |name: &str| read_text(&folder.path().join(name)).unwrap_err().to_string();
        fs::write(folder.path().join("latin.toml"), b"a = 1\nb = '\xe4'\n").unwrap();
        assert!(message("").ends_with(": this is a folder: name a file in it"));
        assert!(message("a.toml").ends_with("a.toml: there is no such file"));
        assert!(message("data/a.toml").contains("data/a.toml: there is no such folder as "));
        assert!(message("latin.toml").ends_with("latin.toml:2: this is not UTF-8 text: save the file in UTF-8"));
        assert!(message("latin.toml/a.toml").contains("latin.toml/a.toml: cannot be read: "));
    }
}
