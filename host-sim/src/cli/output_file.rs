//! A file that appears when it is complete, and not before.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::interruption;
use super::place::Place;
use super::standard_output::UntilClosed;

/// A file that is written beside its place and renamed when it is whole. One that is dropped leaves
/// nothing, and so does a program that is interrupted.
///
/// A link is followed: the file it leads to is replaced, and keeps its owner and permissions; another
/// hard link to it keeps the old text. Standard output (`-`), pipes and devices have nothing to rename
/// and are written as they are; a reader that goes away, as the head of a pipe does, wants no more, and
/// that is no error.
#[derive(Debug)]
pub(super) struct PendingFile(BufWriter<Destination>);

#[derive(Debug)]
enum Destination {
    StandardOutput(UntilClosed<io::Stdout>),
    Device(UntilClosed<File>),
    Beside {
        temporary: NamedTempFile,
        path: PathBuf,
        replace: bool,
    },
}

impl PendingFile {
    /// Begins a file at a place. Unless it may `replace` another, one that has come to be there until
    /// [`commit`](Self::commit) is an error then.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub(super) fn at(place: Place, replace: bool) -> io::Result<Self> {
        let destination = match place {
            Place::StandardOutput => Destination::StandardOutput(UntilClosed(io::stdout())),
            Place::Device(path) => {
                let device = OpenOptions::new().write(true).open(path)?;
                Destination::Device(UntilClosed(device))
            }
            Place::File { path, existing } => {
                let folder = path.parent().unwrap_or(Path::new("/"));
                let temporary = interruption::removing(|| temporary(folder), NamedTempFile::path)?;
                if existing.is_some() {
                    // A rename would replace a file that may not be written, too.
                    let old = OpenOptions::new().write(true).open(&path)?;
                    keep_owner_and_permissions(&old, temporary.as_file())?;
                }
                Destination::Beside {
                    temporary,
                    path,
                    replace,
                }
            }
        };
        Ok(Self(BufWriter::new(destination)))
    }

    /// Ends the file: it is on the disk and has its name, or else nothing is changed.
    ///
    /// # Errors
    /// If not all of it could be written, or the place was taken meanwhile.
    pub(super) fn commit(self) -> io::Result<()> {
        let destination = self
            .0
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        match destination {
            Destination::StandardOutput(mut out) => out.flush(),
            Destination::Device(mut out) => out.flush(),
            Destination::Beside {
                temporary,
                path,
                replace,
            } => {
                temporary.as_file().sync_all()?;
                let renamed = if replace {
                    temporary.persist(path)
                } else {
                    temporary.persist_noclobber(path)
                };
                renamed.map(drop).map_err(|failed| failed.error)
            }
        }
    }
}

impl Write for PendingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::StandardOutput(out) => out.write(bytes),
            Self::Device(out) => out.write(bytes),
            Self::Beside { temporary, .. } => temporary.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::StandardOutput(out) => out.flush(),
            Self::Device(out) => out.flush(),
            Self::Beside { temporary, .. } => temporary.flush(),
        }
    }
}

/// A hidden file that others may read as they may any new file.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".servo-id-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Less what the process masks out.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn keep_owner_and_permissions(old: &File, new: &File) -> io::Result<()> {
    let found = old.metadata()?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Only root can give a file away; anybody else's has the right owner already.
        let _ = fchown(new, Some(found.uid()), Some(found.gid()));
    }
    new.set_permissions(found.permissions())
}
