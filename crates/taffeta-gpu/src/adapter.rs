//! Which GPU: the adapters that there are, and the choice among them.

use std::fmt;

use crate::GpuError;

/// One way to reach one GPU: a device that is reached by two APIs is there twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    /// The device's name, such as `NVIDIA H200`.
    pub name: String,
    /// What sort of device it is.
    pub kind: Kind,
    /// The API that reaches it: `vulkan`, `metal` or `dx12`.
    pub api: String,
    /// The driver and its version; empty where it does not say.
    pub driver: String,
}

/// The sort of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A card with memory of its own.
    Discrete,
    /// A part of the processor, with the processor's memory.
    Integrated,
    /// A device lent by a virtual machine's host.
    Virtual,
    /// A device that does not say what it is.
    Unknown,
    /// A driver that runs kernels on the CPU.
    Software,
}

impl AdapterInfo {
    /// Whether kernels run on the CPU, much slower than on a GPU.
    pub fn is_software(&self) -> bool {
        self.kind == Kind::Software
    }
}

impl From<&wgpu::AdapterInfo> for AdapterInfo {
    fn from(info: &wgpu::AdapterInfo) -> Self {
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => Kind::Discrete,
            wgpu::DeviceType::IntegratedGpu => Kind::Integrated,
            wgpu::DeviceType::VirtualGpu => Kind::Virtual,
            wgpu::DeviceType::Cpu => Kind::Software,
            wgpu::DeviceType::Other => Kind::Unknown,
        };
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        AdapterInfo { name: info.name.clone(), kind, api: info.backend.to_string(), driver }
    }
}

impl fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.api, self.kind)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Discrete => "discrete",
            Kind::Integrated => "integrated",
            Kind::Virtual => "virtual",
            Kind::Unknown => "unknown",
            Kind::Software => "software",
        })
    }
}

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The best hardware; an error where there is none.
    Best,
    /// The best hardware, or a software driver where there is no hardware.
    BestOrSoftware,
    /// The adapter of this number among [`adapters`] (counted from 0), or the first whose name has
    /// this part, in any case.
    Named(String),
}

impl Choice {
    /// What the variable `TAFFETA_ADAPTER` asks for; [`Choice::BestOrSoftware`] where it is unset or empty.
    pub fn from_env() -> Choice {
        match std::env::var("TAFFETA_ADAPTER") {
            Ok(name) if !name.trim().is_empty() => Choice::Named(name.trim().to_owned()),
            _ => Choice::BestOrSoftware,
        }
    }

    /// The number of the chosen one.
    fn among(&self, all: &[AdapterInfo]) -> Result<usize, GpuError> {
        let Choice::Named(wanted) = self else {
            let good = |one: &AdapterInfo| *self == Choice::BestOrSoftware || !one.is_software();
            return all.iter().position(good).ok_or_else(|| none_of(all));
        };
        let number = wanted.parse().ok().filter(|&number: &usize| number < all.len());
        let part = wanted.to_lowercase();
        let named = || all.iter().position(|one| one.to_string().to_lowercase().contains(&part));
        number
            .or_else(named)
            .ok_or_else(|| GpuError::NoSuchAdapter { wanted: wanted.clone(), there: listed(all) })
    }
}

fn none_of(all: &[AdapterInfo]) -> GpuError {
    let but = all.first().map_or(String::new(), |one| format!(", only {one}"));
    GpuError::NoAdapter { but }
}

fn listed(all: &[AdapterInfo]) -> String {
    let lines: Vec<String> = all.iter().enumerate().map(|(number, one)| format!("{number}: {one}")).collect();
    match lines.len() {
        0 => "is none".to_owned(),
        1 => format!("is {}", lines[0]),
        _ => format!("are {}", lines.join("; ")),
    }
}

/// All adapters that there are, hardware first; two calls give the same order.
pub fn adapters() -> Vec<AdapterInfo> {
    found().into_iter().map(|(info, _)| info).collect()
}

/// Opens nothing yet: the chosen adapter.
pub(crate) fn choose(choice: &Choice) -> Result<(AdapterInfo, wgpu::Adapter), GpuError> {
    let mut all = found();
    let infos: Vec<AdapterInfo> = all.iter().map(|(info, _)| info.clone()).collect();
    Ok(all.swap_remove(choice.among(&infos)?))
}

fn found() -> Vec<(AdapterInfo, wgpu::Adapter)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let mut all: Vec<_> = adapters.into_iter().map(|one| (AdapterInfo::from(&one.get_info()), one)).collect();
    all.sort_by_key(|(info, _)| info.kind);
    all
}
