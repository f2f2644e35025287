//! Paths as they are written into a file.

use std::path::Path;

/// `path` as seen from `folder`, with `/` between its parts; as it stands where one of them cannot be resolved.
pub(crate) fn relative_path(folder: &Path, path: &Path) -> String {
    let (Ok(folder), Ok(target)) = (folder.canonicalize(), path.canonicalize()) else {
        return path.to_string_lossy().into_owned();
    };
    let common = folder.components().zip(target.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(common).map(|_| "..".to_owned());
    let down = target.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}
