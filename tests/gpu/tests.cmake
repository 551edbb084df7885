restirpg_test(bsdf_compensation_test
    SOURCES gpu/bsdf_compensation_test.cpp gpu/bsdf_cases.cpp gpu/bsdf_measure.cpp
    LINKS restirpg)
restirpg_test(bsdf_sampling_test
    SOURCES gpu/bsdf_sampling_test.cpp gpu/bsdf_cases.cpp gpu/bsdf_measure.cpp
    LINKS restirpg_core restirpg_gpu)
restirpg_test(bsdf_test
    SOURCES gpu/bsdf_test.cpp gpu/bsdf_energy_test.cpp gpu/bsdf_cases.cpp gpu/bsdf_measure.cpp
    LINKS restirpg_core restirpg_gpu)
restirpg_test(light_test
    SOURCES gpu/light_test.cpp gpu/light_values_test.cpp gpu/texture_test.cpp gpu/light_scenes.cpp
    LINKS restirpg)
restirpg_test(random_test
    SOURCES gpu/random_test.cpp
    LINKS restirpg_core restirpg_gpu)
restirpg_test(kernel_test
    SOURCES gpu/kernel_test.cpp
    LINKS restirpg_core restirpg_gpu)
