restirpg_test(image_test
    SOURCES image/exr_test.cpp image/hostile_test.cpp image/hdr_test.cpp image/png_test.cpp image/metrics_test.cpp
            image/output_file_test.cpp
    LINKS restirpg_core restirpg_image OpenEXR::OpenEXR)
target_include_directories(image_test PRIVATE ${STB_INCLUDE})
