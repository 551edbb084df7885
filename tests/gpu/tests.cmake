restirpg_test(bsdf_sampling_test
    SOURCES gpu/bsdf_sampling_test.cpp gpu/bsdf_cases.cpp
    LINKS restirpg_core restirpg_gpu)
restirpg_test(bsdf_test
    SOURCES gpu/bsdf_test.cpp gpu/bsdf_cases.cpp
    LINKS restirpg_core restirpg_gpu)
