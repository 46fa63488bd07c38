//! Where the name of an output leads, before anything is written there.

use std::fs::{self, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The most links that one name leads through, as Linux has it.
const MAX_LINKS: usize = 40;

/// Names of standard output.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Where a name leads.
#[derive(Debug)]
pub(super) enum Place {
    /// `-`.
    StandardOutput,
    /// A pipe, a terminal, `/dev/null`: what is neither file nor folder.
    Device(PathBuf),
    /// A file, perhaps one that is not there yet.
    File {
        /// Its folder, without links and dots, and its name there.
        path: PathBuf,
        /// The present file.
        existing: Option<Metadata>,
    },
}

impl Place {
    /// True for a name of standard output.
    pub(super) fn is_standard_output(name: &Path) -> bool {
        STANDARD_OUTPUT
            .iter()
            .any(|other| name.as_os_str() == *other)
    }

    /// Follows a name.
    ///
    /// # Errors
    /// If it is a folder's, its folder is missing or closed, or its links go in circles.
    pub(super) fn follow(name: &Path) -> io::Result<Self> {
        if Self::is_standard_output(name) {
            return Ok(Self::StandardOutput);
        }
        match fs::metadata(name) {
            Ok(found) if found.is_dir() => Err(unusable("it is a folder")),
            Ok(found) if found.is_file() => Ok(Self::File {
                path: name.canonicalize()?,
                existing: Some(found),
            }),
            Ok(_) => Ok(Self::Device(name.to_owned())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Self::File {
                path: missing(name)?,
                existing: None,
            }),
            Err(error) => Err(error),
        }
    }
}

/// Where a file would come to be that is not there yet: at the end of the links.
fn missing(name: &Path) -> io::Result<PathBuf> {
    let mut path = name.to_owned();
    for _ in 0..MAX_LINKS {
        let file = path
            .file_name()
            .ok_or_else(|| unusable("it is not the name of a file"))?;
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize()?;
        let place = folder.join(file);
        match fs::read_link(&place) {
            Ok(target) => path = folder.join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(unusable("it has too many symbolic links"))
}

fn unusable(why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, why)
}
