//! Where networks are computed: on the processor, or on an NVIDIA device.

use crate::error::refuse;
use crate::{LearnError, Result};
use candle_core::Device;
use std::fmt;
use std::str::FromStr;

/// A device by its name: `cpu`, `cuda` (the first), `cuda:1` (the second).
///
/// ```
/// use protomer_learn::device::DeviceChoice;
///
/// assert_eq!("cuda:1".parse::<DeviceChoice>().unwrap(), DeviceChoice::Cuda(1));
/// assert!("gpu".parse::<DeviceChoice>().is_err());
/// assert!(DeviceChoice::default().open().unwrap().is_cpu());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// The processor, with the kernels of this crate. Results are the same from run to run, bit for
    /// bit.
    #[default]
    Cpu,
    /// An NVIDIA device, counted from 0, with the tensor library's operations.
    Cuda(usize),
}

impl DeviceChoice {
    /// The device, ready for tensors.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if this build has no CUDA support, or there is no such device.
    pub fn open(self) -> Result<Device> {
        match self {
            Self::Cpu => Ok(Device::Cpu),
            Self::Cuda(_) if !cfg!(feature = "cuda") => refuse(format!(
                "{self}: this program was built without CUDA; build it with --features cuda; or \
                 take cpu"
            )),
            Self::Cuda(number) => Device::new_cuda(number).or_else(|error| {
                // Further lines name places in the library's source.
                let text = error.to_string();
                let reason = text.lines().next().unwrap_or_default();
                refuse(format!(
                    "{self}: no such device can be used ({reason}); or take cpu"
                ))
            }),
        }
    }
}

impl fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cpu => f.write_str("cpu"),
            Self::Cuda(number) => write!(f, "cuda:{number}"),
        }
    }
}

impl FromStr for DeviceChoice {
    type Err = LearnError;

    fn from_str(text: &str) -> Result<Self> {
        let number = text.strip_prefix("cuda:").map(str::parse);
        match (text, number) {
            ("cpu", _) => Ok(Self::Cpu),
            ("cuda", _) => Ok(Self::Cuda(0)),
            (_, Some(Ok(number))) => Ok(Self::Cuda(number)),
            _ => refuse(format!(
                "'{text}' is not a device; give cpu, cuda or cuda:1"
            )),
        }
    }
}
