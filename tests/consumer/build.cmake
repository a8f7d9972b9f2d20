# cmake -DBUILD=… -DWORK=… -DSOURCE=… -DGENERATOR=… -DCOMPILER=… -DBUILD_TYPE=… -DFLAGS=… -DLAUNCHER=… -P build.cmake
# Installs the build into WORK/prefix and builds the embedding host against it, as a project of its own.
function(step what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${text}")
  endif()
  message(STATUS "${what}: done")
endfunction()

# Not the host's build folder: that one may be reused, what it finds must be fresh.
file(REMOVE_RECURSE ${WORK}/prefix)
step("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
step("configure" ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/embed -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
     -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
     -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
step("build" ${CMAKE_COMMAND} --build ${WORK}/embed)

# The point of the exercise: the package that was found is the installed one, and it points at nothing else of ours.
file(STRINGS ${WORK}/embed/CMakeCache.txt found REGEX "^tessera_DIR:")
if(NOT found MATCHES "=${WORK}/prefix/")
  message(FATAL_ERROR "the package was not found under ${WORK}/prefix: ${found}")
endif()
file(GLOB package ${WORK}/prefix/*/cmake/tessera/*.cmake ${WORK}/prefix/*/*/cmake/tessera/*.cmake)
if(NOT package)
  message(FATAL_ERROR "no package files under ${WORK}/prefix")
endif()
foreach(file IN LISTS package)
  file(READ ${file} text)
  foreach(folder ${ROOT} ${BUILD})
    string(FIND "${text}" "${folder}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()
