//! Paths as they are written into a file.

use std::io;
use std::path::{Component, Path, PathBuf};

/// `path` as seen from `folder`, which need not be there yet, with `/` between its parts; as it stands where one of them cannot be
/// resolved.
pub(crate) fn relative_path(folder: &Path, path: &Path) -> String {
    let (Ok(folder), Ok(target)) = (resolved(folder), path.canonicalize()) else {
        return path.to_string_lossy().into_owned();
    };
    let common = folder.components().zip(target.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(common).map(|_| "..".to_owned());
    let down = target.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Without links, as far as there is such a path; what is missing of it stands behind.
fn resolved(folder: &Path) -> io::Result<PathBuf> {
    let absolute = std::path::absolute(folder)?;
    let there = absolute.ancestors().find(|path| path.exists()).unwrap_or(Path::new("/"));
    let mut resolved = there.canonicalize()?;
    for part in absolute.strip_prefix(there).into_iter().flat_map(Path::components) {
        match part {
            Component::ParentDir => drop(resolved.pop()),
            part => resolved.push(part),
        }
    }
    Ok(resolved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_not_there_yet_is_as_far_away_as_it_will_be() {
        let place = tempfile::tempdir().unwrap();
        let robot = place.path().join("robot.toml");
        std::fs::write(&robot, "").unwrap();
        let folder = place.path().join("deep/results");
        assert_eq!(relative_path(&folder, &robot), "../../robot.toml");
        std::fs::create_dir_all(&folder).unwrap();
        assert_eq!(relative_path(&folder, &robot), "../../robot.toml");
    }
}
