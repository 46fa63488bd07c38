//! A file that appears when it is complete, and not before.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::{Builder, NamedTempFile};

use super::fault::Fault;
use super::interruption;
use super::place::Place;
use super::standard_output::UntilClosed;
use crate::present::Page;
use crate::render::html;

/// A file that is written beside its place and renamed when it is whole. One that is dropped leaves
/// nothing, and so does a program that is interrupted.
///
/// A link is followed: its target is replaced and keeps owner and permissions. Another hard link to it keeps the old
/// text. Standard output (`-`), pipes and devices have nothing to rename and are written directly. A reader that closes
/// a pipe early is no error.
#[derive(Debug)]
pub(super) struct Output {
    /// Its requested name.
    name: PathBuf,
    writer: BufWriter<Destination>,
}

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

impl Output {
    /// Begins a file of this name at its place. It replaces the one that is there; one that has come to be there until
    /// [`commit`](Self::commit) is an error then.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub(super) fn begin(name: &Path, place: Place) -> io::Result<Self> {
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
                    replace: existing.is_some(),
                }
            }
        };
        Ok(Self {
            name: name.to_owned(),
            writer: BufWriter::new(destination),
        })
    }

    /// Ends the file: it is on the disk and has its name, or else nothing is changed.
    ///
    /// # Errors
    /// If not all of it could be written, or the place was taken meanwhile.
    pub(super) fn commit(self) -> Result<Option<PathBuf>, Fault> {
        let Self { name, writer } = self;
        let file = matches!(writer.get_ref(), Destination::Beside { .. }).then(|| name.clone());
        let destination = writer.into_inner().map_err(io::IntoInnerError::into_error);
        destination
            .and_then(Destination::commit)
            .map_err(|error| Fault::unwritable(name.display(), &error))?;
        Ok(file)
    }

    /// Its requested name.
    pub(super) fn name(&self) -> &Path {
        &self.name
    }

    /// Writes a document as JSON.
    pub(super) fn document(mut self, document: &impl Serialize) -> Result<Self, Fault> {
        let text = serde_json::to_string_pretty(document)
            .map_err(|error| Fault::Other(format!("{}: {error}", self.name.display())))?;
        self.bytes((text + "\n").as_bytes())?;
        Ok(self)
    }

    /// Writes a report as HTML.
    pub(super) fn page(mut self, page: &Page) -> Result<Self, Fault> {
        self.bytes(html::page(page).as_bytes())?;
        Ok(self)
    }

    /// Writes a table as CSV.
    pub(super) fn table(
        mut self,
        write: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> Result<Self, Fault> {
        match write(&mut self) {
            Ok(()) => Ok(self),
            Err(error) => Err(self.unwritable(&error)),
        }
    }

    /// Writes a part.
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.write_all(bytes)
            .map_err(|error| self.unwritable(&error))
    }

    /// The fault of an output that could not be written completely.
    pub(super) fn unwritable(&self, error: &io::Error) -> Fault {
        Fault::unwritable(self.name.display(), error)
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Destination {
    fn commit(self) -> io::Result<()> {
        match self {
            Self::StandardOutput(mut out) => out.flush(),
            Self::Device(mut out) => out.flush(),
            Self::Beside {
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
        // Only root can give a file away; that of any other user has the right owner already.
        let _ = fchown(new, Some(found.uid()), Some(found.gid()));
    }
    new.set_permissions(found.permissions())
}
