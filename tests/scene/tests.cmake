restirpg_test(test_scene
    SOURCES scene/gltf_builder.cpp scene/test_accessors.cpp scene/test_materials.cpp scene/test_nodes.cpp
    LINKS restirpg_scene restirpg_image restirpg_core)
