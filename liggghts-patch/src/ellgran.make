# SPDX-License-Identifier: GPL-2.0-or-later
# Read by LIGGGHTS' MAKE/Makefile.auto: the library, and what ellipsoids need of LIGGGHTS.
#   make auto ELLGRAN_LIBRARY=/path/to/libellgran.a ELLGRAN_INCLUDE=/path/to/include
# The same two variables may stand in MAKE/Makefile.user.

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
