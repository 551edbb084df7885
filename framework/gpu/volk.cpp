// The one translation unit that holds the Vulkan entry points.
#define VOLK_IMPLEMENTATION
#include <volk.h>
