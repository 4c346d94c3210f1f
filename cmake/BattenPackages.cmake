# Debian packages of the installed components, made and checked by tools/package: batten, libbatten-dev, python3-batten
# (where it is built) and batten-studio.
set(BATTEN_PACKAGE_CONTACT "The Batten contributors <batten@example.org>" CACHE STRING
    "Maintainer named in the packages: whoever gives them to others says here where to write to")
set(CPACK_PACKAGE_CONTACT ${BATTEN_PACKAGE_CONTACT})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # every package has its own, the first line of its description
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME batten)
set(CPACK_PACKAGE_VENDOR "The Batten contributors")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SOURCE batten)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

# Policy asks for a copyright and a changelog in every package; who installs without packages has LICENSE and CHANGELOG.md.
set(BATTEN_NOTICE [[
file(MAKE_DIRECTORY "${place}")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH
file(WRITE "${place}/changelog.Debian"
     "batten (${version}) unstable; urgency=medium\n\n  * What is new: changelog.gz beside this file.\n\n -- ${contact}  ${date}\n")
file(COPY_FILE "${source}/CHANGELOG.md" "${place}/changelog")
file(COPY_FILE "${source}/packaging/copyright" "${place}/copyright")
execute_process(COMMAND gzip -9nf "${place}/changelog.Debian" "${place}/changelog" COMMAND_ERROR_IS_FATAL ANY)
]])

# batten_package(<component> NAME <package> SECTION <section> DESCRIPTION <text> [DEPENDS <packages>] [RECOMMENDS <packages>]
#                [CONTROL <scripts>...] [LINKED] [SAME_EVERYWHERE])
# LINKED: it holds a program or module; the packages of the libraries that this is linked with are found by themselves, by a
# look into every file of the package. SAME_EVERYWHERE: it holds nothing that is for one kind of processor.
set(components)
function(batten_package component)
  cmake_parse_arguments(PACKAGE "LINKED;SAME_EVERYWHERE" "NAME;SECTION;DESCRIPTION;DEPENDS;RECOMMENDS" CONTROL ${ARGN})
  install(CODE "
    set(place \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/doc/${PACKAGE_NAME}\")
    set(source \"${PROJECT_SOURCE_DIR}\")
    set(version ${version})
    set(contact \"${BATTEN_PACKAGE_CONTACT}\")
    ${BATTEN_NOTICE}" COMPONENT ${component} EXCLUDE_FROM_ALL)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${PACKAGE_NAME} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${PACKAGE_SECTION} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION ${PACKAGE_DESCRIPTION} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS ${PACKAGE_DEPENDS} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS ${PACKAGE_RECOMMENDS} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA ${PACKAGE_CONTROL} PARENT_SCOPE)
  if(PACKAGE_SAME_EVERYWHERE)
    set(CPACK_DEBIAN_${upper}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
  endif()
  if(PACKAGE_LINKED)
    set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ON PARENT_SCOPE)
  endif()
  set(components ${components} ${component} PARENT_SCOPE)
endfunction()

set(what "Batten turns curves that were traced on an object, with an inertial sensor
or a pen or in a drawing program, into a fair surface, and processes meshes.
")
# CHOLMOD is content with any BLAS, and several times slower with the reference.
batten_package(program NAME batten SECTION graphics RECOMMENDS libopenblas0 LINKED
  DESCRIPTION "turns curves traced on an object into a fair surface
${what}This package holds the program, its manual and the documents.")

set(depends "libeigen3-dev, libgmp-dev, libosd-dev, libpng-dev, zlib1g-dev")
if(JPEG_FOUND)
  string(APPEND depends ", libjpeg-dev")
endif()
if(CHOLMOD_FOUND)
  string(APPEND depends ", libsuitesparse-dev")
endif()
if(OpenCascade_FOUND)
  string(APPEND depends ", libocct-data-exchange-dev")
endif()
batten_package(development NAME libbatten-dev SECTION libdevel DEPENDS "${depends}"
  DESCRIPTION "fair surfaces from curve networks: C++ library
${what}This package holds the static libraries with their headers, a CMake package
and a file for pkg-config.")

if(TARGET batten_python)
  math(EXPR next "${BATTEN_PYTHON_MINOR} + 1")
  batten_package(python NAME python3-batten SECTION python RECOMMENDS libopenblas0 LINKED
    DEPENDS "python3 (>= 3.${BATTEN_PYTHON_MINOR}), python3 (<< 3.${next}), python3-numpy"
    CONTROL ${PROJECT_SOURCE_DIR}/packaging/python/postinst ${PROJECT_SOURCE_DIR}/packaging/python/prerm
    DESCRIPTION "fair surfaces from curve networks: Python package
${what}This package holds the Python package, functions on arrays.")
endif()

batten_package(studio NAME batten-studio SECTION graphics DEPENDS "batten (= ${version})" RECOMMENDS xdg-utils SAME_EVERYWHERE
  DESCRIPTION "Batten in the browser: entry in the menu and file types
${what}The program serves the studio to the browser of the same machine. This
package puts it into the menu of the desktop and opens its files with it.")

set(CPACK_COMPONENTS_ALL ${components})
include(CPack)
