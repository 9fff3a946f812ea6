//! The crate's error: one variant for each kind of thing that can go wrong, naming the place and the cure.

use crate::FieldPath;
use std::path::PathBuf;
use std::time::Duration;

/// Result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file is not what its format demands.
    #[error("{path}: {field}: {problem}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The key, section or line at fault.
        field: String,
        /// What is wrong, and how to mend it.
        problem: String,
    },
    /// A value handed to the library is unusable.
    #[error("{field}: {problem}")]
    Invalid {
        /// The argument or field at fault.
        field: FieldPath,
        /// What is wrong, and how to mend it.
        problem: String,
    },
    /// A linear system could not be factored or solved.
    #[error("{system}: {problem}")]
    Solve {
        /// Which system.
        system: &'static str,
        /// What failed, with the pivot where it is known.
        problem: String,
    },
    /// A state or a result held a value that is not finite. Whoever says so keeps what it had: a step the state before it.
    #[error("{quantity} is not finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
    },
    /// The graphics device refused, is missing or was lost.
    #[error("GPU: {0}")]
    Gpu(#[from] GpuError),
}

/// What can go wrong between the library and a graphics device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter fits the choice.
    #[error("no adapter: {0}")]
    NoAdapter(String),
    /// The adapter refused to make a device.
    #[error("the adapter made no device: {0}")]
    NoDevice(String),
    /// The device was lost, or a buffer could not be read back; make a new device and a new potential.
    #[error("device lost: {0}")]
    DeviceLost(String),
    /// A kernel does not compile.
    #[error("kernel {kernel}: {message}")]
    Shader {
        /// The kernel.
        kernel: String,
        /// What the compiler said, with the line.
        message: String,
    },
    /// A kernel names a buffer that it was not given.
    #[error("kernel {kernel}: nothing is bound to `{binding}`")]
    MissingBuffer {
        /// The kernel.
        kernel: String,
        /// The name in the kernel's text.
        binding: String,
    },
    /// More is needed than the device or the options allow.
    #[error("{what}: {needed} needed, {limit} allowed; {cure}")]
    Limit {
        /// What is too large.
        what: String,
        /// How much is needed.
        needed: u64,
        /// How much there may be.
        limit: u64,
        /// What to change.
        cure: &'static str,
    },
    /// The device has no memory for what is to be made.
    #[error("no memory on the device: {0}; use fewer instances or a smaller avatar")]
    Memory(String),
    /// The device took longer than a host waits. It may still be at it: what it was asked for is lost, the state is not.
    #[error(
        "{what} did not come within {waited:?}: the device hangs or is busy; raise GpuOptions::timeout, give it less at \
         once, or make a new device"
    )]
    Timeout {
        /// What was awaited.
        what: String,
        /// How long.
        waited: Duration,
    },
}

impl Error {
    /// An [`Error::Invalid`] of `field`.
    pub fn invalid(field: impl Into<FieldPath>, problem: impl Into<String>) -> Self {
        Self::Invalid {
            field: field.into(),
            problem: problem.into(),
        }
    }

    /// An [`Error::Format`] of `path`.
    pub fn format(
        path: impl Into<PathBuf>,
        field: impl Into<String>,
        problem: impl Into<String>,
    ) -> Self {
        Self::Format {
            path: path.into(),
            field: field.into(),
            problem: problem.into(),
        }
    }

    /// An [`Error::Invalid`] of a field that `outer` holds; any other as it is.
    pub fn within(self, outer: &str) -> Self {
        match self {
            Self::Invalid { field, problem } => Self::invalid(field.within(outer), problem),
            other => other,
        }
    }

    /// An [`Error::Invalid`] as one of the file it came from; any other as it is.
    pub fn of_file(self, path: impl Into<PathBuf>) -> Self {
        match self {
            Self::Invalid { field, problem } => Self::format(path, field, problem),
            other => other,
        }
    }

    /// An [`Error::Io`] of `path`.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io {
            path: path.into(),
            source,
        }
    }
}
