# Makes the Debian packages, unpacks them into a fresh folder and uses what they hold.
#
#   cmake -DBUILD=... -DWORK=... -DPYTHON=... -P packages.cmake
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT status EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\nended with ${status}:\n${said}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND cpack --config ${BUILD}/CPackConfig.cmake -B ${WORK}/packages WORKING_DIRECTORY ${WORK}
                RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "cpack ended with ${status}:\n${said}")
endif()
foreach(PACKAGE veridyn python3-veridyn libveridyn-dev libveridyn[0-9]* veridyn-[a-z]*)
  file(GLOB FILE ${WORK}/packages/${PACKAGE}_*.deb)
  if(NOT FILE AND NOT PACKAGE MATCHES "[[]")  # the library's own package is there where it is shared
    message(FATAL_ERROR "cpack made no ${PACKAGE}")
  endif()
  foreach(DEB IN LISTS FILE)
    run(dpkg-deb -x ${DEB} ${WORK}/root)
  endforeach()
endforeach()
set(ENV{LD_LIBRARY_PATH} ${WORK}/root/usr/lib)
file(GLOB HEADER ${WORK}/root/usr/include/veridyn/veridyn.hpp)
if(NOT HEADER)
  message(FATAL_ERROR "libveridyn-dev has no headers")
endif()
run(${WORK}/root/usr/bin/veridyn info psm-3dof)
set(ENV{PYTHONPATH} ${WORK}/root/usr/lib/python3/dist-packages)
run(${PYTHON} -c "import os, veridyn
assert veridyn.__file__.startswith('${WORK}/root'), veridyn.__file__
assert os.environ['VERIDYN_ROBOTS'].startswith('${WORK}/root')
arm = veridyn.read_model('psm-3dof').with_plausible_values(1)
assert veridyn.inverse_dynamics(arm, [0, 0, 0.1], [0, 0, 0], [0, 0, 0]).shape == (3,)")
