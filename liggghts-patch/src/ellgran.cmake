# SPDX-License-Identifier: GPL-2.0-or-later
# Included at the end of LIGGGHTS' src/CMakeLists.txt: the library, and what ellipsoids need of LIGGGHTS.
#   cmake -DELLGRAN_LIBRARY=/path/to/libellgran.a -DELLGRAN_INCLUDE=/path/to/include ...
# With VTK 9, which LIGGGHTS itself does not find:
#   -DELLGRAN_VTK_INCLUDE=/path/to/include/vtk-9.1 -DELLGRAN_VTK_LIBRARIES=/directory/of/its/libraries

FIND_LIBRARY(ELLGRAN_LIBRARY NAMES libellgran.a DOC "ellgran: the static library")
FIND_PATH(ELLGRAN_INCLUDE NAMES ellgran.h DOC "ellgran: directory of ellgran.h")
IF(NOT ELLGRAN_LIBRARY OR NOT ELLGRAN_INCLUDE)
  MESSAGE(FATAL_ERROR "ellgran: give -DELLGRAN_LIBRARY=/path/to/libellgran.a and -DELLGRAN_INCLUDE=/path/to/its/include")
ENDIF()

ADD_DEFINITIONS(-DSUPERQUADRIC_ACTIVE_FLAG -DNONSPHERICAL_ACTIVE_FLAG)
# LIGGGHTS takes the beta function from C++17, TR1 or Boost, and looks for it in its own make alone.
INCLUDE(CheckIncludeFileCXX)
CHECK_INCLUDE_FILE_CXX(tr1/cmath ELLGRAN_HAVE_TR1_CMATH)
IF(ELLGRAN_HAVE_TR1_CMATH)
  ADD_DEFINITIONS(-DHAVE_TR1_CMATH)
ENDIF()

# LIGGGHTS lists its styles while it is built, after ninja has looked which files are new: in a tree that was built before, a new
# style of ours would be missing until the tree is built once more.
EXECUTE_PROCESS(COMMAND sh Make.sh style WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_QUIET)

INCLUDE_DIRECTORIES(${ELLGRAN_INCLUDE})
FIND_PACKAGE(Threads REQUIRED)
# The mathematical library comes first: the Rust library brings functions of the same names, some of them slower (cbrt), and
# the linker takes what it meets first, for LIGGGHTS too. The C++ compiler would move a plain -lm to the end.
FOREACH(target liggghts_static liggghts_shared liggghts_bin)
  TARGET_LINK_LIBRARIES(${target} -Wl,-lm ${ELLGRAN_LIBRARY} ${CMAKE_THREAD_LIBS_INIT} ${CMAKE_DL_LIBS})
ENDFOREACH()

IF(ELLGRAN_VTK_INCLUDE)
  GET_FILENAME_COMPONENT(ELLGRAN_VTK_SUFFIX ${ELLGRAN_VTK_INCLUDE} NAME)
  STRING(REPLACE "vtk" "" ELLGRAN_VTK_SUFFIX ${ELLGRAN_VTK_SUFFIX})
  IF(NOT EXISTS ${ELLGRAN_VTK_INCLUDE}/vtkVersion.h OR
     NOT EXISTS ${ELLGRAN_VTK_LIBRARIES}/libvtkIOParallelXML${ELLGRAN_VTK_SUFFIX}.so)
    MESSAGE(FATAL_ERROR "ellgran: no vtkVersion.h in ELLGRAN_VTK_INCLUDE=${ELLGRAN_VTK_INCLUDE}, or no libvtkIOParallelXML${ELLGRAN_VTK_SUFFIX}.so in ELLGRAN_VTK_LIBRARIES=${ELLGRAN_VTK_LIBRARIES}")
  ENDIF()
  # The sources that know VTK, or the list of all dumps, alone: VTK needs a newer C++ than LIGGGHTS.
  # A header of ours comes first: it stands in for one of VTK's.
  FOREACH(source ${SOURCES})
    FILE(STRINGS ${source} knows_vtk REGEX "LAMMPS_VTK|style_dump.h" LIMIT_COUNT 1)
    IF(knows_vtk)
      SET_PROPERTY(SOURCE ${source} APPEND_STRING PROPERTY COMPILE_FLAGS
        " -DLAMMPS_VTK -std=gnu++11 -I${CMAKE_CURRENT_SOURCE_DIR}/ellgran_vtk -isystem ${ELLGRAN_VTK_INCLUDE}")
    ENDIF()
  ENDFOREACH()
  FOREACH(target liggghts_static liggghts_shared liggghts_bin)
    # An old-fashioned search path serves the libraries' own libraries too.
    TARGET_LINK_LIBRARIES(${target} -Wl,--disable-new-dtags -Wl,-rpath,${ELLGRAN_VTK_LIBRARIES})
    FOREACH(name IOParallelXML IOXML IOLegacy IOCore ParallelCore FiltersCore CommonExecutionModel CommonDataModel CommonMisc
                 CommonCore sys)
      TARGET_LINK_LIBRARIES(${target} ${ELLGRAN_VTK_LIBRARIES}/libvtk${name}${ELLGRAN_VTK_SUFFIX}.so)
    ENDFOREACH()
  ENDFOREACH()
ENDIF()
