# SPDX-License-Identifier: GPL-2.0-or-later
# Read by LIGGGHTS' MAKE/Makefile.auto: the library, what ellipsoids need of LIGGGHTS, and VTK 9, which LIGGGHTS does not know.
#   make auto ELLGRAN_LIBRARY=/path/to/libellgran.a ELLGRAN_INCLUDE=/path/to/include
# The same two variables may stand in MAKE/Makefile.user, and so may, where VTK 9 is not found by itself,
#   ELLGRAN_VTK_INCLUDE=/path/to/include/vtk-9.1 ELLGRAN_VTK_LIBRARIES=/directory/of/its/libraries

ifeq (,$(wildcard $(ELLGRAN_LIBRARY)))
    $(error ellgran: ELLGRAN_LIBRARY='$(ELLGRAN_LIBRARY)' is no file: give the absolute path of libellgran.a)
endif
ifeq (,$(wildcard $(ELLGRAN_INCLUDE)/ellgran.h))
    $(error ellgran: ELLGRAN_INCLUDE='$(ELLGRAN_INCLUDE)' holds no ellgran.h: give the absolute path of its directory)
endif
ifneq ($(USE_SUPERQUADRICS), "ON")
    $(error ellgran: ellipsoids need USE_SUPERQUADRICS = "ON" in $(MAKEUSER))
endif

EXTRA_INC += -I$(ELLGRAN_INCLUDE)
# The mathematical library comes first: the Rust library brings functions of the same names, some of them slower (cbrt), and
# the linker takes what it meets first, for LIGGGHTS too.
EXTRA_ADDLIBS += -Wl,-lm $(ELLGRAN_LIBRARY) -lpthread -ldl

# Makefile.auto itself finds VTK 5 to 8 and stops at any other, or at none. Unless the user names one, here VTK 9 is used where it
# is, and LIGGGHTS built without VTK where there is none at all.
ifeq ($(USE_VTK)$(VTK_INC)$(VTK_INC_USR), "ON")
    ELLGRAN_VTK_INCLUDE ?= $(lastword $(sort $(wildcard /usr/include/vtk-9* /usr/local/include/vtk-9*)))
    ifneq (,$(wildcard $(ELLGRAN_VTK_INCLUDE)/vtkVersion.h))
        ellgran_vtk_suffix := $(patsubst vtk%,%,$(notdir $(ELLGRAN_VTK_INCLUDE)))
        ellgran_vtk_prefix := $(patsubst %/include/,%,$(dir $(ELLGRAN_VTK_INCLUDE)))
        ELLGRAN_VTK_LIBRARIES ?= $(patsubst %/,%,$(dir $(firstword $(wildcard \
            $(foreach place,lib/* lib lib64,$(ellgran_vtk_prefix)/$(place)/libvtkIOParallelXML$(ellgran_vtk_suffix).so)))))
        ifeq (,$(wildcard $(ELLGRAN_VTK_LIBRARIES)/libvtkIOParallelXML$(ellgran_vtk_suffix).so))
            $(error ellgran: ELLGRAN_VTK_LIBRARIES='$(ELLGRAN_VTK_LIBRARIES)' holds no libvtkIOParallelXML$(ellgran_vtk_suffix).so: give the absolute path of its directory)
        endif
        LMP_INC += -DLAMMPS_VTK
        # A header of ours comes first: it stands in for one of VTK's.
        EXTRA_INC += -I../ellgran_vtk -isystem $(ELLGRAN_VTK_INCLUDE)
        EXTRA_LIB += -L$(ELLGRAN_VTK_LIBRARIES)
        # An old-fashioned search path serves the libraries' own libraries too.
        EXTRA_ADDLIBS += -Wl,--disable-new-dtags $(foreach name,IOParallelXML IOXML IOLegacy IOCore ParallelCore FiltersCore \
            CommonExecutionModel CommonDataModel CommonMisc CommonCore sys,-lvtk$(name)$(ellgran_vtk_suffix))
        override USE_VTK := "OFF"
    else ifeq (,$(wildcard /usr/include/vtk-[5678]* $(LIB_PATH)/vtk/install/include/vtk*)$(filter "ON",$(AUTOINSTALL_VTK)))
        $(info ellgran: WARNING: no VTK found here: LIGGGHTS is built without its VTK dumps)
        override USE_VTK := "OFF"
    endif
endif
