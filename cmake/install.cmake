# The package: headers under include/tessera as they lie in the tree, one static library a room, assets, and
# find_package(tessera) with the targets tessera::engine, tessera::atlas, tessera::gl and what they stand on, and
# tessera::codec where it was built: who does not link it needs no libavcodec.
include(CMakePackageConfigHelpers)

# What only the rooms themselves include stays out: engine_state.hpp, the loader's parts behind gltf.hpp, and what
# tessera_atlas_bench holds; of codec, how the two ends of a stream code it.
set(rooms engine atlas)
if(TARGET tessera_codec)
  list(APPEND rooms codec)
else()
  install(DIRECTORY codec/wire DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tessera/codec FILES_MATCHING PATTERN "*.hpp"
          PATTERN "geometry_*.hpp" EXCLUDE PATTERN "range_coder.hpp" EXCLUDE PATTERN "stream_state.hpp" EXCLUDE
          PATTERN "slots.hpp" EXCLUDE PATTERN "bytes.hpp" EXCLUDE)
endif()
install(DIRECTORY ${rooms} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tessera FILES_MATCHING PATTERN "*.hpp"
        PATTERN "engine_state.hpp" EXCLUDE PATTERN "gltf_*.hpp" EXCLUDE
        PATTERN "request_stream.hpp" EXCLUDE PATTERN "place_tracker.hpp" EXCLUDE
        PATTERN "quadtree*.hpp" EXCLUDE
        PATTERN "libav.hpp" EXCLUDE PATTERN "frame_planes.hpp" EXCLUDE
        PATTERN "encoder_settings.hpp" EXCLUDE
        PATTERN "geometry_coding.hpp" EXCLUDE PATTERN "geometry_models.hpp" EXCLUDE
        PATTERN "range_coder.hpp" EXCLUDE PATTERN "stream_state.hpp" EXCLUDE PATTERN "slots.hpp" EXCLUDE
        PATTERN "bytes.hpp" EXCLUDE)
install(DIRECTORY glsl/shared DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tessera/glsl)
install(DIRECTORY ${PROJECT_BINARY_DIR}/engine/gl/glad/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tessera)
install(DIRECTORY assets/ DESTINATION ${CMAKE_INSTALL_DATADIR}/tessera/assets
        FILES_MATCHING PATTERN "*.glb" PATTERN "*.json" PATTERN "__pycache__" EXCLUDE)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tessera)
set(TESSERA_ASSETS ${CMAKE_INSTALL_DATADIR}/tessera/assets)
configure_package_config_file(cmake/tesseraConfig.cmake.in ${PROJECT_BINARY_DIR}/tesseraConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS TESSERA_ASSETS)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tesseraConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tesseraConfig.cmake ${PROJECT_BINARY_DIR}/tesseraConfigVersion.cmake
        DESTINATION ${package_dir})
install(EXPORT tesseraTargets NAMESPACE tessera:: DESTINATION ${package_dir})
