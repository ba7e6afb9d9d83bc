//! The device flag, shared by verbs that run networks.

use anyhow::Result;
use clap::Args;
use protomer_learn::Device;
use protomer_learn::device::DeviceChoice;

/// The device for networks.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub struct DeviceArgs {
    /// Device that runs the network: cpu, cuda, or cuda:1 for the second NVIDIA device. CUDA needs
    /// a build with --features cuda.
    #[arg(long, default_value_t)]
    device: DeviceChoice,
}

impl DeviceArgs {
    /// The device, ready for use.
    ///
    /// # Errors
    /// If there is no such device.
    pub fn open(&self) -> Result<Device> {
        Ok(self.device.open()?)
    }
}
