# Installs the library into a fresh folder, then configures, builds and runs the project of somebody who has only that.
#
#   cmake -DBUILD=... -DSTRANGER=... -DWORK=... -DCXX=... -P stranger.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
run(${CMAKE_COMMAND} -S ${STRANGER} -B ${WORK}/build -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_CXX_COMPILER=${CXX})
run(${CMAKE_COMMAND} --build ${WORK}/build)
# Only the robots that were installed, from a folder of its own.
set(ENV{VERIDYN_ROBOTS} ${WORK}/installed/share/veridyn/robots)
run(${WORK}/build/stranger)
run(${WORK}/installed/bin/veridyn info planar-2r)
