# The installed tree has the shape of the build tree and may be moved as a whole:
#   bin/restirpg   lib/librestirpg.so   lib/restirpg/passes   lib/cmake/restirpg
#   include/restirpg   share/restirpg/{shaders,python,graphs,default.ocio}
# `lib` whatever the distribution's own habit: core/paths.cpp looks for share/restirpg beside it.
# A wheel (pyproject.toml) holds the same tree in the folder of the Python package, which is its prefix: the component "wheel" stands
# there for the component "python".
include(CMakePackageConfigHelpers)

install(TARGETS restirpg EXPORT restirpgTargets LIBRARY DESTINATION lib)
install(EXPORT restirpgTargets NAMESPACE restirpg:: DESTINATION lib/cmake/restirpg)
if(TARGET restirpg_app)
    set_target_properties(restirpg_app PROPERTIES INSTALL_RPATH "$ORIGIN/../lib")
    install(TARGETS restirpg_app RUNTIME DESTINATION bin)
endif()
if(TARGET restirpg_python)
    set_target_properties(restirpg_python PROPERTIES INSTALL_RPATH "$ORIGIN/lib;$ORIGIN/../../../../lib")
    install(TARGETS restirpg_python LIBRARY DESTINATION share/restirpg/python/restirpg COMPONENT python)
    install(TARGETS restirpg_python LIBRARY DESTINATION . COMPONENT wheel EXCLUDE_FROM_ALL)
endif()

install(DIRECTORY core gpu graph image render scene shaders DESTINATION include/restirpg FILES_MATCHING PATTERN "*.h")
install(DIRECTORY shaders DESTINATION share/restirpg)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/scripts/restirpg DESTINATION share/restirpg/python COMPONENT python
    PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/graphs DESTINATION share/restirpg FILES_MATCHING PATTERN "*.py")
install(FILES image/default.ocio DESTINATION share/restirpg)

configure_package_config_file(cmake/restirpgConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/restirpgConfig.cmake
    INSTALL_DESTINATION lib/cmake/restirpg)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/restirpgConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/restirpgConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/restirpgConfigVersion.cmake
    cmake/restirpgPass.cmake DESTINATION lib/cmake/restirpg)

# What rendering needs, without the tests: the program, the Python module and every pass of this repository.
add_custom_target(renderer)
foreach(target IN ITEMS restirpg restirpg_app restirpg_python)
    if(TARGET ${target})
        add_dependencies(renderer ${target})
    endif()
endforeach()
