// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// How many virtual functions has a class, by the headers of LAMMPS and in the LAMMPS that runs?
///
/// Updates of one release carry the same version text, and have changed classes nevertheless.

#ifndef ELLGRAN_CLASS_LAYOUT_H
#define ELLGRAN_CLASS_LAYOUT_H

#include <cstddef>
#include <cstring>
#include <string>

#if defined(__linux__) && defined(__GLIBC__)
#include <dlfcn.h>
#include <link.h>
#endif

namespace LAMMPS_NS {

/// By the headers: `first` is the first virtual function that a derived class adds. 0 where this compiler keeps tables of
/// virtual functions otherwise than the Itanium C++ ABI.
template <class Class> std::size_t ellgran_virtual_functions(void (Class::*first)())
{
#if defined(__GXX_ABI_VERSION) && (defined(__x86_64__) || defined(__i386__))
  // Such a pointer is one more than the function's offset in the table.
  std::ptrdiff_t offset[2];
  static_assert(sizeof offset == sizeof first);
  std::memcpy(offset, &first, sizeof first);
  return static_cast<std::size_t>(offset[0] - 1) / sizeof(void *);
#elif defined(__GXX_ABI_VERSION) && defined(__aarch64__)
  // There it is the offset itself; the second word tells that the function is virtual.
  std::ptrdiff_t offset[2];
  static_assert(sizeof offset == sizeof first);
  std::memcpy(offset, &first, sizeof first);
  return static_cast<std::size_t>(offset[0]) / sizeof(void *);
#else
  return 0;
#endif
}

/// In the LAMMPS that runs, for a class by its mangled name; 0 where the system does not tell.
inline std::size_t ellgran_virtual_functions_of(const std::string &mangled_class)
{
#if defined(__linux__) && defined(__GLIBC__)
  void *table = dlsym(RTLD_DEFAULT, ("_ZTV" + mangled_class).c_str());
  Dl_info info{};
  ElfW(Sym) *symbol = nullptr;
  if (table && dladdr1(table, &info, reinterpret_cast<void **>(&symbol), RTLD_DL_SYMENT) && symbol &&
      info.dli_saddr == table && symbol->st_size > 2 * sizeof(void *))
    return symbol->st_size / sizeof(void *) - 2;    // without the offset to the top and the type
#endif
  return 0;
}

}    // namespace LAMMPS_NS

#endif
