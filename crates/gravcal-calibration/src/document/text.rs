//! Reading a text file, with errors that say what to do.

use std::fs;
use std::io;
use std::path::Path;

use super::file_error::FileError;

/// The text of a file.
///
/// # Errors
/// There is no such file or folder, it is a folder, the operating system refuses, or it is not UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String, FileError> {
    let bytes = fs::read(path).map_err(|error| opening_error(path, &error))?;
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
    use super::*;

    #[test]
    fn what_cannot_be_read_is_told_apart() {
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
