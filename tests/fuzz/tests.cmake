# One program for all targets, for clang alone: scripts/fuzz configures it, with the sanitizers, into a folder of its own.
option(RESTIRPG_FUZZ "Build the fuzz targets" OFF)
if(RESTIRPG_FUZZ)
    add_executable(restirpg_fuzz fuzz/fuzz.cpp fuzz/mutate.cpp fuzz/read.cpp fuzz/seeds.cpp scene/gltf_builder.cpp)
    target_link_libraries(restirpg_fuzz PRIVATE restirpg_core restirpg_image restirpg_scene restirpg_graph
        GTest::gtest ZLIB::ZLIB -fsanitize=fuzzer)
    restirpg_compile_as_one_file(restirpg_fuzz)
endif()
