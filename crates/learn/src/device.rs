//! Where networks are computed: on the processor, or on an NVIDIA device.

use crate::{LearnError, Result};
use candle_core::Device;
use std::fmt;
use std::str::FromStr;

/// A device by its name: `cpu`, `cuda` (the first), `cuda:1` (the second).
///
/// ```
/// use protomer_learn::device::DeviceChoice;
/// assert_eq!("cuda:1".parse::<DeviceChoice>().unwrap(), DeviceChoice::Cuda(1));
/// assert!("gpu".parse::<DeviceChoice>().is_err());
/// assert!(DeviceChoice::default().open().unwrap().is_cpu());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// The processor, with the direct kernels of this crate: bit for bit the same from run to run.
    #[default]
    Cpu,
    /// An NVIDIA device, counted from 0, with the tensor library's operations in the place of the
    /// kernels.
    Cuda(usize),
}

impl DeviceChoice {
    /// The device, ready for tensors.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if this build knows no CUDA, or there is no such device.
    pub fn open(self) -> Result<Device> {
        let refuse =
            |reason: String| LearnError::Settings(format!("{self}: {reason}; or take cpu"));
        match self {
            Self::Cpu => Ok(Device::Cpu),
            Self::Cuda(_) if !cfg!(feature = "cuda") => Err(refuse(
                "this program was built without CUDA; build it with --features cuda".into(),
            )),
            Self::Cuda(number) => Device::new_cuda(number).map_err(|error| {
                // The library appends where in its source it was; the first line says what is
                // wrong.
                let text = error.to_string();
                refuse(format!(
                    "no such device can be used ({})",
                    text.lines().next().unwrap_or_default()
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
            _ => Err(LearnError::Settings(format!(
                "'{text}' is no device; give cpu, cuda or cuda:1"
            ))),
        }
    }
}
