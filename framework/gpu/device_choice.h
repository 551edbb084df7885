// Which device and which back end a renderer takes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace restirpg {

/// Which ray tracing back end the kernels are compiled for.
enum class Backend {
    software,  ///< two-level BVH2 traversed in the kernel; any device
    rayQuery,  ///< GL_EXT_ray_query
};

/// As users write it.
inline const char* nameOf(Backend backend)
{
    return backend == Backend::rayQuery ? "rayquery" : "software";
}

struct DeviceOptions {
    /// Index or part of the name, as `restirpg devices` lists them; empty: discrete, else integrated, else CPU
    std::string device;
    std::string backend;  ///< "software", "rayquery" or empty: ray query where the device has it and is no CPU
    /// Validation layer with synchronization validation; RESTIRPG_VALIDATION=1 turns it on too
    bool validation = false;
};

/// A physical device as `restirpg devices` shows it.
struct DeviceDescription {
    std::string name;
    std::string driver;  ///< name and version
    std::string type;  ///< "discrete GPU", "integrated GPU", "virtual GPU", "CPU"
    bool rayQuery = false;
    bool shaderObject = false;  ///< VK_EXT_shader_object
    std::vector<std::string> missing;  ///< required features it lacks; empty: usable

    bool isCpu() const { return type == "CPU"; }
};

/// The one that DeviceOptions::device names: digits alone are an index. Throws WrongValue when there is none.
size_t chooseDevice(const std::vector<DeviceDescription>& devices, const std::string& wanted);

/// That of DeviceOptions::backend. Throws WrongValue for another name, Error where the device cannot.
Backend chooseBackend(const DeviceDescription& device, const std::string& wanted);

/// Throws Error naming what the device lacks, and the mend.
void refuseIncomplete(const DeviceDescription& device);

/// Whether kernels are shader objects rather than pipelines.
bool usesShaderObjects(const DeviceDescription& device, Backend backend, bool validated);

}  // namespace restirpg
