# Configures and builds a package by itself on the installed library, and asks its program for its help.
#
#   cmake -DPACKAGE=... -DPROGRAM=... -DSOURCE=... -DINSTALLED=... -DWORK=... -DCXX=... -P package_alone.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/packages/${PACKAGE} -B ${WORK} -DCMAKE_PREFIX_PATH=${INSTALLED} -DCMAKE_CXX_COMPILER=${CXX}
    -DCMAKE_CXX_FLAGS_RELEASE=-O0)
run(${CMAKE_COMMAND} --build ${WORK})
run(${WORK}/bin/${PROGRAM} --describe)
