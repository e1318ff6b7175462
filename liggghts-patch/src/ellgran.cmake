# SPDX-License-Identifier: GPL-2.0-or-later
# Included at the end of LIGGGHTS' src/CMakeLists.txt: the library, and what ellipsoids need of LIGGGHTS.
#   cmake -DELLGRAN_LIBRARY=/path/to/libellgran.a -DELLGRAN_INCLUDE=/path/to/include ...

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

INCLUDE_DIRECTORIES(${ELLGRAN_INCLUDE})
FIND_PACKAGE(Threads REQUIRED)
# The mathematical library comes first: the Rust library brings functions of the same names, some of them slower (cbrt), and
# the linker takes what it meets first, for LIGGGHTS too. The C++ compiler would move a plain -lm to the end.
FOREACH(target liggghts_static liggghts_shared liggghts_bin)
  TARGET_LINK_LIBRARIES(${target} -Wl,-lm ${ELLGRAN_LIBRARY} ${CMAKE_THREAD_LIBS_INIT} ${CMAKE_DL_LIBS})
ENDFOREACH()
