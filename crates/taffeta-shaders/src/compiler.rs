//! The driver's compiler, by way of `VK_KHR_pipeline_executable_properties`.

use crate::kernels::Buffer;
use ash::prelude::VkResult;
use ash::vk;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};

/// A device that compiles.
pub struct Compiler {
    device: ash::Device,
    executables: ash::khr::pipeline_executable_properties::Device,
    name: String,
    driver: String,
    instance: ash::Instance,
    /// What the functions above come from.
    _entry: ash::Entry,
}

impl Drop for Compiler {
    fn drop(&mut self) {
        // SAFETY: nothing of the device is left, and the instance has no other.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

fn words(error: vk::Result) -> String {
    format!("Vulkan: {error}")
}

impl Compiler {
    /// The first device of the driver.
    ///
    /// # Errors
    /// Says that there is no Vulkan, no device, or what the device lacks.
    pub fn new() -> Result<Self, String> {
        // SAFETY: the library that is found is the system's Vulkan loader.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| format!("no Vulkan loader: {error}"))?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: `info` names no layers, extensions or callbacks.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(words)?;
        match Self::device(&instance) {
            Ok((device, name, driver)) => {
                let executables = ash::khr::pipeline_executable_properties::Device::new(&instance, &device);
                Ok(Self { device, executables, name, driver, instance, _entry: entry })
            }
            Err(error) => {
                // SAFETY: it has no device.
                unsafe { instance.destroy_instance(None) };
                Err(error)
            }
        }
    }

    fn device(instance: &ash::Instance) -> Result<(ash::Device, String, String), String> {
        // SAFETY: the instance is alive, as in all calls below; all that they point to outlives them.
        let physical = unsafe { instance.enumerate_physical_devices() }.map_err(words)?;
        let &physical = physical.first().ok_or("the driver has no device")?;
        let mut of_driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut of_driver);
        // SAFETY: the device is one of the instance's.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        if properties.properties.api_version < vk::API_VERSION_1_3 {
            return Err("the driver is of a Vulkan before 1.3, which kernels are written for here".into());
        }
        let name =
            properties.properties.device_name_as_c_str().unwrap_or(c"?").to_string_lossy().into_owned();
        let driver = of_driver.driver_info_as_c_str().unwrap_or(c"?").to_string_lossy().into_owned();
        let extensions =
            [vk::KHR_PIPELINE_EXECUTABLE_PROPERTIES_NAME, vk::EXT_ROBUSTNESS2_NAME].map(CStr::as_ptr);
        let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut robust = vk::PhysicalDeviceRobustness2FeaturesEXT::default().robust_buffer_access2(true);
        let mut version_13 = vk::PhysicalDeviceVulkan13Features::default()
            .shader_zero_initialize_workgroup_memory(true)
            .subgroup_size_control(true);
        let mut memory = vk::PhysicalDeviceVulkan12Features::default().vulkan_memory_model(true);
        let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features)
            .push_next(&mut statistics)
            .push_next(&mut robust)
            .push_next(&mut version_13)
            .push_next(&mut memory);
        // SAFETY: as above; what the device lacks of what `info` asks for is an error that it returns.
        let device = unsafe { instance.create_device(physical, &info, None) }
            .map_err(|error| format!("{name}: {error}"))?;
        Ok((device, name, driver))
    }

    /// The device's name.
    pub fn device_name(&self) -> String {
        self.name.clone()
    }

    /// The driver's version.
    pub fn driver(&self) -> String {
        self.driver.clone()
    }

    /// What the compiler says of a kernel, by its own names.
    ///
    /// # Errors
    /// Those of Vulkan.
    pub fn statistics(
        &self,
        entry: &str,
        words: &[u32],
        buffers: &[Buffer],
    ) -> VkResult<BTreeMap<String, f64>> {
        let groups = buffers.iter().map(|one| one.group + 1).max().unwrap_or(0);
        let mut sets = Vec::new();
        let result = (0..groups)
            .try_for_each(|group| {
                sets.push(self.set(buffers, group)?);
                Ok(())
            })
            .and_then(|()| self.compiled(entry, words, &sets));
        for set in sets {
            // SAFETY: what was made of it is gone.
            unsafe { self.device.destroy_descriptor_set_layout(set, None) };
        }
        result
    }

    fn set(&self, buffers: &[Buffer], group: u32) -> VkResult<vk::DescriptorSetLayout> {
        let kind = |is_uniform| {
            if is_uniform { vk::DescriptorType::UNIFORM_BUFFER } else { vk::DescriptorType::STORAGE_BUFFER }
        };
        let bindings: Vec<_> = buffers
            .iter()
            .filter(|one| one.group == group)
            .map(|one| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(one.binding)
                    .descriptor_type(kind(one.is_uniform))
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: each binding has one buffer and a number of its own, as naga has checked.
        unsafe { self.device.create_descriptor_set_layout(&info, None) }
    }

    fn compiled(
        &self,
        entry: &str,
        words: &[u32],
        sets: &[vk::DescriptorSetLayout],
    ) -> VkResult<BTreeMap<String, f64>> {
        let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(sets);
        let module = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words are what naga has made of a source that it has validated; all is destroyed once.
        unsafe {
            let layout = self.device.create_pipeline_layout(&layout, None)?;
            let result = self.device.create_shader_module(&module, None).and_then(|module| {
                let result = self.pipeline(entry, module, layout).and_then(|pipeline| {
                    let result = self.read(pipeline);
                    self.device.destroy_pipeline(pipeline, None);
                    result
                });
                self.device.destroy_shader_module(module, None);
                result
            });
            self.device.destroy_pipeline_layout(layout, None);
            result
        }
    }

    fn pipeline(
        &self,
        entry: &str,
        module: vk::ShaderModule,
        layout: vk::PipelineLayout,
    ) -> VkResult<vk::Pipeline> {
        let name = CString::new(entry).map_err(|_| vk::Result::ERROR_UNKNOWN)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(&name);
        let info = vk::ComputePipelineCreateInfo::default()
            .flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
            .stage(stage)
            .layout(layout);
        // SAFETY: the module has that entry point, and the layout the buffers that it uses.
        let made = unsafe { self.device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
        made.map(|all| all[0]).map_err(|(_, error)| error)
    }

    fn read(&self, pipeline: vk::Pipeline) -> VkResult<BTreeMap<String, f64>> {
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(0);
        // SAFETY: the pipeline is one of the device's.
        let executables = unsafe {
            self.executables
                .get_pipeline_executable_properties(&vk::PipelineInfoKHR::default().pipeline(pipeline))
        }?;
        if executables.is_empty() {
            return Err(vk::Result::ERROR_FEATURE_NOT_PRESENT);
        }
        // SAFETY: the pipeline was made with statistics, and has a first executable.
        let all = unsafe { self.executables.get_pipeline_executable_statistics(&info) }?;
        Ok(all
            .iter()
            .map(|one| {
                let name = one.name_as_c_str().unwrap_or(c"?").to_string_lossy().into_owned();
                (name, number(one))
            })
            .collect())
    }
}

fn number(one: &vk::PipelineExecutableStatisticKHR<'_>) -> f64 {
    // SAFETY: the format says which of the fields was written.
    unsafe {
        match one.format {
            vk::PipelineExecutableStatisticFormatKHR::BOOL32 => f64::from(one.value.b32),
            vk::PipelineExecutableStatisticFormatKHR::INT64 => one.value.i64 as f64,
            vk::PipelineExecutableStatisticFormatKHR::UINT64 => one.value.u64 as f64,
            _ => one.value.f64,
        }
    }
}
