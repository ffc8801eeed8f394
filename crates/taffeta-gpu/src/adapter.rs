//! Which GPU: the adapters that there are, and the choice among them.

use std::fmt;

use crate::GpuError;

/// One way to reach one GPU: a device that is reached by two APIs is there twice.
///
/// ```
/// use taffeta_gpu::{AdapterInfo, Kind};
///
/// let (name, api) = ("NVIDIA H200".to_owned(), "vulkan".to_owned());
/// let info = AdapterInfo { name, kind: Kind::Discrete, api, driver: String::new() };
/// assert_eq!(info.to_string(), "NVIDIA H200 (vulkan, discrete)");
/// assert!(!info.is_software());
/// ```
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
///
/// ```
/// use taffeta_gpu::Kind;
///
/// // What is preferred comes first.
/// assert!(Kind::Discrete < Kind::Integrated && Kind::Integrated < Kind::Software);
/// assert_eq!(Kind::Discrete.to_string(), "discrete");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Kind {
    /// A card with memory of its own.
    Discrete,
    /// A part of the processor, with the processor's memory.
    Integrated,
    /// A virtual GPU.
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
///
/// ```
/// use taffeta_gpu::Choice;
///
/// // A flag of your program, or else what TAFFETA_ADAPTER asks for.
/// let flag = Some("nvidia".to_owned());
/// let choice = flag.map_or_else(Choice::from_env, Choice::Named);
/// assert_eq!(choice, Choice::Named("nvidia".to_owned()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Choice {
    /// The best hardware; an error where there is none.
    Best,
    /// The best hardware, or a software driver where there is no hardware.
    BestOrSoftware,
    /// The adapter of this number among [`adapters`] (counted from 0), or the first that is listed
    /// with these words in its name, API, kind or driver, in any case.
    Named(String),
}

impl Choice {
    /// What the variable `TAFFETA_ADAPTER` asks for; [`Choice::BestOrSoftware`] where it is unset or empty.
    pub fn from_env() -> Choice {
        let name = std::env::var_os("TAFFETA_ADAPTER").unwrap_or_default();
        match name.to_string_lossy().trim() {
            "" => Choice::BestOrSoftware,
            name => Choice::Named(name.to_owned()),
        }
    }

    /// The number of the chosen one.
    fn among(&self, all: &[AdapterInfo]) -> Result<usize, GpuError> {
        let Choice::Named(wanted) = self else {
            let good = |one: &AdapterInfo| *self == Choice::BestOrSoftware || !one.is_software();
            return all.iter().position(good).ok_or_else(|| none_of(all));
        };
        if all.is_empty() {
            return Err(none_of(all));
        }
        let part = wanted.to_lowercase();
        let found = match wanted.parse() {
            Ok(number) => Some(number).filter(|&number: &usize| number < all.len()),
            Err(_) => {
                all.iter().position(|one| format!("{one}, {}", one.driver).to_lowercase().contains(&part))
            }
        };
        found.ok_or_else(|| GpuError::NoSuchAdapter { wanted: wanted.clone(), there: listed(all) })
    }
}

fn none_of(all: &[AdapterInfo]) -> GpuError {
    let hint = match all.first() {
        Some(one) => format!(", only {one}, which runs on the CPU: TAFFETA_ADAPTER=0 asks for it"),
        None => "; a Vulkan, Metal or DirectX 12 driver would do (on Debian, \
                 `apt-get install mesa-vulkan-drivers libvulkan1` installs one that runs on the CPU)"
            .to_owned(),
    };
    GpuError::NoAdapter { hint }
}

fn listed(all: &[AdapterInfo]) -> String {
    let lines: Vec<String> = all.iter().enumerate().map(|(number, one)| format!("{number}: {one}")).collect();
    match lines.len() {
        1 => format!("is {}", lines[0]),
        _ => format!("are {}", lines.join("; ")),
    }
}

/// All adapters that there are, hardware first; two calls give the same order.
///
/// ```no_run
/// use taffeta_gpu::{Choice, Gpu, adapters};
///
/// for (number, one) in adapters().iter().enumerate() {
///     println!("{number}: {one}, driver {}", one.driver);
/// }
/// let first = Gpu::open(&Choice::Named("0".to_owned()))?;
/// assert_eq!(first.info(), &adapters()[0]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub fn adapters() -> Vec<AdapterInfo> {
    found().into_iter().map(|(info, _)| info).collect()
}

/// The chosen adapter, not opened yet.
pub(crate) fn choose(choice: &Choice) -> Result<(AdapterInfo, wgpu::Adapter), GpuError> {
    let mut all = found();
    let infos: Vec<AdapterInfo> = all.iter().map(|(info, _)| info.clone()).collect();
    Ok(all.swap_remove(choice.among(&infos)?))
}

fn found() -> Vec<(AdapterInfo, wgpu::Adapter)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // wgpu would put a dispatch and two barriers before each one whose workgroups are counted on the device, to check the
    // counts. `DispatchList::dispatch_counted` says what is asked of them instead.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let mut all: Vec<_> = adapters.into_iter().map(|one| (AdapterInfo::from(&one.get_info()), one)).collect();
    all.sort_by_key(|(info, _)| info.kind);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(name: &str, kind: Kind, api: &str) -> AdapterInfo {
        AdapterInfo { name: name.to_owned(), kind, api: api.to_owned(), driver: String::new() }
    }

    fn several() -> Vec<AdapterInfo> {
        vec![
            one("NVIDIA H200", Kind::Discrete, "vulkan"),
            one("NVIDIA H200", Kind::Discrete, "dx12"),
            one("Iris 5", Kind::Integrated, "vulkan"),
            one("llvmpipe", Kind::Software, "vulkan"),
        ]
    }

    fn named(name: &str) -> Choice {
        Choice::Named(name.to_owned())
    }

    #[test]
    fn an_adapter_is_named_by_part_of_how_it_is_listed_or_by_its_number() {
        for (name, number) in [("h200", 0), ("IRIS", 2), ("dx12", 1), ("software", 3), ("2", 2), ("0", 0)] {
            assert_eq!(named(name).among(&several()), Ok(number), "{name}");
        }
    }

    #[test]
    fn what_is_likely_to_be_fast_comes_first() {
        use Kind::{Discrete, Integrated, Software, Unknown, Virtual};
        assert!([Discrete, Integrated, Virtual, Unknown, Software].is_sorted());
    }

    #[test]
    fn a_number_is_never_part_of_a_name() {
        let error = named("5").among(&several()[2..]).expect_err("there is no number 5");
        assert_eq!(
            error.to_string(),
            "TAFFETA_ADAPTER=`5` fits no adapter; \
             there are 0: Iris 5 (vulkan, integrated); 1: llvmpipe (vulkan, software)"
        );
    }

    #[test]
    fn software_is_taken_only_where_it_may_be_and_nothing_else_is_there() {
        let software = &several()[3..];
        assert_eq!(Choice::BestOrSoftware.among(&several()), Ok(0));
        assert_eq!(Choice::BestOrSoftware.among(software), Ok(0));
        let error = Choice::Best.among(software).expect_err("it is software");
        assert_eq!(
            error.to_string(),
            "no GPU was found, only llvmpipe (vulkan, software), which runs on the CPU: \
             TAFFETA_ADAPTER=0 asks for it"
        );
    }

    #[test]
    fn without_any_adapter_the_error_says_what_to_install() {
        for choice in [Choice::Best, Choice::BestOrSoftware, named("h200")] {
            let error = choice.among(&[]).expect_err("there is none").to_string();
            assert!(error.contains("apt-get install mesa-vulkan-drivers"), "{error}");
        }
    }
}
