restirpg_test(test_scene
    SOURCES scene/gltf_builder.cpp scene/test_accessors.cpp scene/test_alias_table.cpp scene/test_deform.cpp scene/test_hostile.cpp
            scene/test_hostile_images.cpp scene/test_lights.cpp scene/test_materials.cpp scene/test_mutations.cpp
            scene/test_nodes.cpp scene/test_numbers.cpp scene/test_samples.cpp scene/test_uris.cpp
    LINKS restirpg_scene restirpg_image restirpg_core ZLIB::ZLIB)
