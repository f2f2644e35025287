//! A file is opened here only if it can be read from its beginning more than once.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// The most bytes that a document may hold which people write and which is read as a whole: a session, a robot, a study.
pub const LARGEST_DOCUMENT: u64 = 4 << 20;

/// The most bytes that a file of results may hold to be read as a whole: a calibration with its covariance, what a study is.
pub const LARGEST_RESULTS: u64 = 512 << 20;

/// All that a file holds, which are no more than `most` bytes.
///
/// # Errors
///
/// It cannot be read, holds more, or is a folder, a pipe or a device.
pub fn read_whole(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    opened(path)?.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => {
            let what = format!("it holds more than {most} bytes, and no file of its kind does");
            Err(io::Error::new(io::ErrorKind::FileTooLarge, what))
        }
        false => Ok(bytes),
    }
}

/// A file as people are told of it: the last part of its path.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A path as it is typed into a command: in quotes where a shell would take it for several words, or for more than a name.
pub fn in_command(path: &Path) -> String {
    let path = path.to_string_lossy();
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+,:=@%".contains(letter);
    match !path.is_empty() && path.chars().all(plain) {
        true => path.into_owned(),
        false => format!("'{}'", path.replace('\'', r"'\''")),
    }
}

/// Whether a file holds these bytes and no others. No more of it is read than that takes.
///
/// # Errors
///
/// It cannot be read, or is a folder, a pipe or a device.
pub fn holds(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    match read_whole(path, bytes.len() as u64) {
        Ok(found) => Ok(found == bytes),
        Err(error) if error.kind() == io::ErrorKind::FileTooLarge => Ok(false),
        Err(error) => Err(error),
    }
}

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
        // Files of a folder are opened by their endings.
        for name in ["a.db3", "a.mcap"] {
            let bag = folder.path().join(name).with_extension("");
            fs::create_dir_all(&bag).unwrap();
            assert!(Command::new("mkfifo").arg(bag.join(name)).status().unwrap().success());
            assert!(open(&bag).err().unwrap().to_string().contains("it is a pipe"), "{name}");
            fs::remove_dir_all(&bag).unwrap();
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
    fn no_more_is_read_than_is_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.toml");
        fs::write(&file, "abc").unwrap();
        assert_eq!(read_whole(&file, 3).unwrap(), b"abc");
        assert_eq!(read_whole(&file, 2).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        let reported = [&b"abc"[..], b"abd", b"ab", b"abcd"].map(|bytes| holds(&file, bytes).unwrap());
        assert_eq!(reported, [true, false, false, false]);
        // Without an end: it would never return.
        for error in
            [read_whole(Path::new("/dev/zero"), 3).unwrap_err(), holds(Path::new("/dev/zero"), b"").unwrap_err()]
        {
            assert_eq!(error.to_string(), "it is a device, and no file");
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

    #[test]
    fn a_path_is_one_word_of_a_command() {
        let typed = |path: &str| in_command(Path::new(path));
        assert_eq!(typed("../day-1/arm_2.toml"), "../day-1/arm_2.toml");
        assert_eq!(typed("my day/Prüfstand.toml"), "'my day/Prüfstand.toml'");
        assert_eq!(typed("it's"), r"'it'\''s'");
    }
}
