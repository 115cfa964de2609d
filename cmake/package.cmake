# veridyn_package(NAME SOURCES file... NEEDS component... [LINKS library...]
#                 PROGRAM file... COMMANDS command... [NEEDS_PACKAGES name...] [SCRIPTS file...])
# A package on top of the library: the component veridyn::NAME of SOURCES, which stands on NEEDS, and the program
# veridyn-COMMAND of PROGRAM for each of its commands (links to one program). SCRIPTS are what its pages add to the scripts of a page,
# as NAME_file("script.js"). NEEDS_PACKAGES name packages below it. The same within the library's build and on an installed library,
# whose version it has.
include(GNUInstallDirs)
set(VERIDYN_CMAKE_DIR ${CMAKE_CURRENT_LIST_DIR})

# veridyn_package_alone(component...): what a package needs when it is built by itself, on an installed library with those components.
macro(veridyn_package_alone)
  if(PROJECT_IS_TOP_LEVEL)
    set(CMAKE_CXX_STANDARD 17)
    set(CMAKE_CXX_EXTENSIONS OFF)
    set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
    if(NOT CMAKE_BUILD_TYPE)
      set(CMAKE_BUILD_TYPE Release)
    endif()
    find_package(veridyn REQUIRED COMPONENTS ${ARGN})
  endif()
endmacro()

function(veridyn_package name)
  cmake_parse_arguments(PART "" "" "SOURCES;NEEDS;LINKS;PROGRAM;COMMANDS;NEEDS_PACKAGES;SCRIPTS" ${ARGN})
  set(target veridyn_${name})
  find_package(CLI11 REQUIRED)
  find_package(fmt REQUIRED)
  find_package(nlohmann_json REQUIRED)
  set(needs ${PART_NEEDS} ${PART_NEEDS_PACKAGES})
  list(TRANSFORM needs PREPEND veridyn::)
  add_library(${target} ${PART_SOURCES})
  add_library(veridyn::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON DEFINE_SYMBOL ""
    VERSION ${veridyn_VERSION} SOVERSION ${veridyn_VERSION_MAJOR}.${veridyn_VERSION_MINOR} INSTALL_RPATH $ORIGIN)
  # A public header is "dvrk/run/arm_session.hpp" to the package itself.
  set(folders ${CMAKE_CURRENT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR}/include/veridyn)
  target_include_directories(${target}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include> PRIVATE ${folders})
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_compile_definitions(${target} PRIVATE VERIDYN_VERSION="${veridyn_VERSION}")
  target_link_libraries(${target} PUBLIC ${needs} PRIVATE ${PART_LINKS})

  # Its commands, JSON and pages: behind the program, for Python and for tests; not installed.
  list(POP_FRONT PART_PROGRAM main)
  if(PART_SCRIPTS)
    list(TRANSFORM PART_SCRIPTS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    list(JOIN PART_SCRIPTS "|" scripts)
    add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}_files.cpp
      COMMAND ${CMAKE_COMMAND} "-DOUT=${CMAKE_CURRENT_BINARY_DIR}/${name}_files.cpp" "-DFILES=script.js|${scripts}" -DFUNCTION=${name}_file
              -P ${VERIDYN_CMAKE_DIR}/embed_files.cmake
      DEPENDS ${VERIDYN_CMAKE_DIR}/embed_files.cmake ${PART_SCRIPTS} COMMENT "Embedding the page scripts of ${name}" VERBATIM)
    list(APPEND PART_PROGRAM ${CMAKE_CURRENT_BINARY_DIR}/${name}_files.cpp)
  endif()
  add_library(${target}_commands STATIC ${PART_PROGRAM})
  target_include_directories(${target}_commands PUBLIC ${folders})
  target_compile_definitions(${target}_commands PUBLIC VERIDYN_VERSION="${veridyn_VERSION}")
  target_compile_options(${target}_commands PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(${target}_commands PUBLIC veridyn::${name} veridyn::tool CLI11::CLI11 fmt::fmt nlohmann_json::nlohmann_json)
  set_target_properties(${target}_commands PROPERTIES POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL PROPERTY VERIDYN_COMMANDS_${name} ${PART_COMMANDS})
  list(POP_FRONT PART_COMMANDS first)
  add_executable(veridyn_${first}_program ${main})
  target_link_libraries(veridyn_${first}_program PRIVATE ${target}_commands)
  set_target_properties(veridyn_${first}_program PROPERTIES OUTPUT_NAME veridyn-${first} INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
  install(TARGETS veridyn_${first}_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${name})
  foreach(command IN LISTS PART_COMMANDS)
    add_custom_command(TARGET veridyn_${first}_program POST_BUILD COMMAND ${CMAKE_COMMAND} -E create_symlink
      veridyn-${first} $<TARGET_FILE_DIR:veridyn_${first}_program>/veridyn-${command} VERBATIM)
    install(FILES $<TARGET_FILE_DIR:veridyn_${first}_program>/veridyn-${command} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${name})
  endforeach()

  install(DIRECTORY include/veridyn DESTINATION include COMPONENT ${name})
  if(COMMAND veridyn_unity_groups)
    veridyn_unity_groups(${target} SIZE 12 ALONE ${VERIDYN_ALONE})
    veridyn_unity_groups(${target}_commands SIZE 7 ALONE ${VERIDYN_ALONE} OVERLOADED run)
  endif()
  if(TARGET veridyn_core)  # within the library's build
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:veridyn_warnings>)
    target_link_libraries(${target}_commands PRIVATE veridyn_warnings)
    target_link_libraries(veridyn_${first}_program PRIVATE veridyn_warnings)
    # Headers that are compiled already go with the macros of the library.
    get_target_property(macros veridyn_core COMPILE_DEFINITIONS)
    target_compile_definitions(${target} PRIVATE ${macros})
    target_compile_definitions(${target}_commands PRIVATE ${macros})
    target_precompile_headers(${target} REUSE_FROM veridyn_core)
    target_precompile_headers(${target}_commands REUSE_FROM veridyn_tool_library)
    target_link_libraries(veridyn INTERFACE ${target})
    add_dependencies(veridyn_libraries ${target})
    add_dependencies(veridyn_programs veridyn_${first}_program)
    # The library's list of components, for the installed package.
    set_property(GLOBAL APPEND PROPERTY VERIDYN_PACKAGES ${name})
    set_property(GLOBAL PROPERTY VERIDYN_NEEDS_${name} ${PART_NEEDS} ${PART_NEEDS_PACKAGES})
    set_property(GLOBAL PROPERTY VERIDYN_DESCRIPTION_${name} "${PROJECT_DESCRIPTION}")
  endif()
endfunction()
