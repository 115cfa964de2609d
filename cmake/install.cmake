# Headers, library, tool and robots; others find them with find_package(veridyn COMPONENTS ...) or with pkg-config.
include(CMakePackageConfigHelpers)
set(PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/veridyn)

# Each component of the library has an export and a .pc file of its own. Who links a static one needs what stands behind
# it; a shared one knows that itself.
foreach(ROW fmt::fmt|fmt|-lfmt yaml-cpp|yaml-cpp|-lyaml-cpp muparser::muparser|muparser|-lmuparser pugixml::pugixml|pugixml|-lpugixml
        "Ceres::ceres|Ceres|-lceres -lglog" Threads::Threads|Threads|-pthread CLI11::CLI11|CLI11| )
  string(REPLACE "|" ";" ROW "${ROW}")
  list(GET ROW 0 LINK)
  list(GET ROW 1 VERIDYN_PACKAGE_${LINK})
  list(GET ROW 2 VERIDYN_PC_${LINK})
endforeach()
get_property(ADDED GLOBAL PROPERTY VERIDYN_PACKAGES)
foreach(component IN LISTS ADDED)
  get_property(veridyn_needs_${component} GLOBAL PROPERTY VERIDYN_NEEDS_${component})
endforeach()
list(JOIN VERIDYN_COMPONENTS ", veridyn-" PC_ALL)
list(APPEND VERIDYN_COMPONENTS ${ADDED})
set(VERIDYN_NEEDS "")
set(VERIDYN_PACKAGES "")
file(RELATIVE_PATH PC_TO_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
foreach(component IN LISTS VERIDYN_COMPONENTS)
  get_target_property(target veridyn::${component} ALIASED_TARGET)
  set(DEV dev)
  set(LIBRARY library)
  if(component IN_LIST ADDED)  # a package is installed as one
    set(DEV ${component})
    set(LIBRARY ${component})
  endif()
  install(TARGETS ${target} EXPORT veridyn_${component}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${DEV}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${LIBRARY} NAMELINK_COMPONENT ${DEV})
  install(EXPORT veridyn_${component} NAMESPACE veridyn:: FILE veridyn_${component}.cmake DESTINATION ${PACKAGE_DIR} COMPONENT ${DEV})
  string(APPEND VERIDYN_NEEDS "set(veridyn_needs_${component} ${veridyn_needs_${component}})\n")
  set(PACKAGES "")
  set(PC_LIBS "")
  set(PC_NEEDS eigen3)
  foreach(needed IN LISTS veridyn_needs_${component})
    string(APPEND PC_NEEDS ", veridyn-${needed}")
  endforeach()
  if(NOT BUILD_SHARED_LIBS)
    get_target_property(LINKS ${target} LINK_LIBRARIES)
    foreach(LINK IN LISTS LINKS)
      if(LINK MATCHES "^veridyn|^Eigen3::|BUILD_INTERFACE")
        continue()
      elseif(LINK MATCHES "^/")  # by its name where the linker looks for it by itself
        string(REGEX REPLACE "^/usr/lib(/[^/]*-linux-gnu)?/lib([^/]+)\\.(so|a)$" "-l\\2" LINK "${LINK}")
        string(APPEND PC_LIBS " ${LINK}")
      elseif(DEFINED VERIDYN_PC_${LINK})
        string(APPEND PC_LIBS " ${VERIDYN_PC_${LINK}}")
        list(APPEND PACKAGES ${VERIDYN_PACKAGE_${LINK}})
      else()
        message(FATAL_ERROR "cmake/install.cmake: found ${LINK} behind veridyn::${component}, expected it in the table above")
      endif()
    endforeach()
    list(REMOVE_DUPLICATES PACKAGES)
  endif()
  string(APPEND VERIDYN_PACKAGES "set(veridyn_packages_${component} ${PACKAGES})\n")
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/veridyn-${component}.pc @ONLY CONTENT [=[
prefix=${pcfiledir}/@PC_TO_PREFIX@
Name: veridyn-@component@
Description: @PROJECT_DESCRIPTION@: @component@
Version: @PROJECT_VERSION@
Requires: @PC_NEEDS@
Cflags: -I${prefix}/include
Libs: -L${prefix}/@CMAKE_INSTALL_LIBDIR@ -lveridyn_@component@@PC_LIBS@
]=])
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/veridyn-${component}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT ${DEV})
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/veridyn.pc @ONLY CONTENT [=[
Name: veridyn
Description: @PROJECT_DESCRIPTION@
Version: @PROJECT_VERSION@
Requires: veridyn-@PC_ALL@
]=])
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/veridyn.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

# The components below are Debian packages, see packages.cmake.
if(TARGET veridyn_tool)
  install(TARGETS veridyn_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tool)
  # Man pages and completion come from the tool's own help; they are written when it is installed, each with the commands it is about.
  set(OF_PACKAGES none)
  foreach(package IN LISTS ADDED)
    get_property(COMMANDS GLOBAL PROPERTY VERIDYN_COMMANDS_${package})
    list(JOIN COMMANDS "|" PAGES_${package})
    string(APPEND OF_PACKAGES "|${PAGES_${package}}")
  endforeach()
  foreach(component tool ${ADDED})
    set(MAN ${CMAKE_CURRENT_BINARY_DIR}/man/${component})
    set(KEEP "INCLUDE REGEX \"/veridyn-(${PAGES_${component}})[.-]\"")
    if(component STREQUAL "tool")
      set(KEEP "EXCLUDE REGEX \"/veridyn-(${OF_PACKAGES})[.-]\"")
    endif()
    install(CODE "file(REMOVE_RECURSE ${MAN})
      execute_process(COMMAND $<TARGET_FILE:veridyn_tool> help --man ${MAN} COMMAND_ERROR_IS_FATAL ANY)
      file(GLOB pages ${MAN}/*.1)
      list(FILTER pages ${KEEP})
      execute_process(COMMAND gzip -9nf \${pages} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
    install(DIRECTORY ${MAN}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component} FILES_MATCHING PATTERN "*.gz")
  endforeach()
  install(CODE "execute_process(COMMAND $<TARGET_FILE:veridyn_tool> help --bash ${CMAKE_CURRENT_BINARY_DIR}/veridyn.bash COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT tool)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/veridyn.bash DESTINATION share/bash-completion/completions RENAME veridyn COMPONENT tool)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/veridyn DESTINATION include COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/robots DESTINATION share/veridyn COMPONENT tool)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/veridynConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/veridynConfig.cmake INSTALL_DESTINATION ${PACKAGE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/veridynConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/veridynConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/veridynConfigVersion.cmake
        DESTINATION ${PACKAGE_DIR} COMPONENT dev)

# Licence and versions, as every Debian package has them.
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/changelog "veridyn (${PROJECT_VERSION}) unstable; urgency=medium

  * Changes are listed in CHANGELOG.md of the sources.

 -- veridyn maintainers <maintainers@example.org>  Thu, 01 Jan 2026 00:00:00 +0000
")
execute_process(COMMAND gzip -9nfk ${CMAKE_CURRENT_BINARY_DIR}/changelog COMMAND_ERROR_IS_FATAL ANY)
set(ROWS ${ADDED})
list(TRANSFORM ROWS REPLACE "(.+)" "\\1|veridyn-\\1")
foreach(ROW tool|veridyn dev|libveridyn-dev library|libveridyn${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} python|python3-veridyn ${ROWS})
  string(REPLACE "|" ";" ROW "${ROW}")
  list(GET ROW 0 component)
  list(GET ROW 1 package)
  set(NOT_BY_DEFAULT "")
  if(component MATCHES "library|python")
    set(NOT_BY_DEFAULT EXCLUDE_FROM_ALL)
  endif()
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/${package} RENAME copyright COMPONENT ${component} ${NOT_BY_DEFAULT})
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz DESTINATION share/doc/${package} COMPONENT ${component} ${NOT_BY_DEFAULT})
endforeach()

include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
