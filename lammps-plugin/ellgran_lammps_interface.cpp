// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which members of LAMMPS' classes does the plugin rely on, and are they what they were? Compiled before everything else: where
/// a release of LAMMPS has changed one, the compiler names it.

#include "atom.h"
#include "atom_vec_ellipsoid.h"
#include "atom_vec_hybrid.h"
#include "comm.h"
#include "fix.h"
#include "fix_neigh_history.h"
#include "force.h"
#include "modify.h"
#include "neigh_list.h"
#include "pair.h"
#include "update.h"

#include <cstdio>
#include <type_traits>

using namespace LAMMPS_NS;

// A member of that name and type, a function or a value. One that is gone or overloaded counts as changed.
#define REQUIRE(CLASS, MEMBER, ...)                                                                              \
  namespace {                                                                                                    \
  template <class C, class = void> struct CLASS##_##MEMBER : std::false_type {};                                 \
  template <class C>                                                                                             \
  struct CLASS##_##MEMBER<C, std::void_t<decltype(&C::MEMBER)>>                                                  \
      : std::is_same<decltype(&C::MEMBER), __VA_ARGS__> {};                                                      \
  }                                                                                                              \
  static_assert(CLASS##_##MEMBER<CLASS>::value,                                                                  \
                "this LAMMPS has changed " #CLASS "::" #MEMBER ", which the plugin takes for " #__VA_ARGS__)

REQUIRE(Atom, x, double **Atom::*);
REQUIRE(Atom, v, double **Atom::*);
REQUIRE(Atom, f, double **Atom::*);
REQUIRE(Atom, torque, double **Atom::*);
REQUIRE(Atom, angmom, double **Atom::*);
REQUIRE(Atom, rmass, double *Atom::*);
REQUIRE(Atom, ellipsoid, int *Atom::*);
REQUIRE(Atom, type, int *Atom::*);
REQUIRE(Atom, mask, int *Atom::*);
REQUIRE(Atom, tag, tagint *Atom::*);
REQUIRE(Atom, nlocal, int Atom::*);
REQUIRE(Atom, nghost, int Atom::*);
REQUIRE(Atom, ntypes, int Atom::*);
REQUIRE(Atom, avec, AtomVec *Atom::*);
REQUIRE(Atom, ellipsoid_flag, int Atom::*);

using EllipsoidBonus = AtomVecEllipsoid::Bonus;
REQUIRE(AtomVecEllipsoid, bonus, EllipsoidBonus *AtomVecEllipsoid::*);
REQUIRE(EllipsoidBonus, shape, double (EllipsoidBonus::*)[3]);
REQUIRE(EllipsoidBonus, quat, double (EllipsoidBonus::*)[4]);
REQUIRE(AtomVecHybrid, nstyles, int AtomVecHybrid::*);
REQUIRE(AtomVecHybrid, styles, AtomVec **AtomVecHybrid::*);

REQUIRE(Pair, compute, void (Pair::*)(int, int));
REQUIRE(Pair, settings, void (Pair::*)(int, char **));
REQUIRE(Pair, coeff, void (Pair::*)(int, char **));
REQUIRE(Pair, init_style, void (Pair::*)());
REQUIRE(Pair, init_one, double (Pair::*)(int, int));
REQUIRE(Pair, single, double (Pair::*)(int, int, int, int, double, double, double, double &));
REQUIRE(Pair, transfer_history, void (Pair::*)(double *, double *, int, int));
REQUIRE(Pair, reset_dt, void (Pair::*)());
REQUIRE(Pair, list, NeighList *Pair::*);
REQUIRE(Pair, svector, double *Pair::*);

REQUIRE(Fix, setmask, int (Fix::*)());
REQUIRE(Fix, init, void (Fix::*)());
REQUIRE(Fix, setup, void (Fix::*)(int));
REQUIRE(Fix, post_force, void (Fix::*)(int));
REQUIRE(Fix, compute_vector, double (Fix::*)(int));
REQUIRE(Fix, grow_arrays, void (Fix::*)(int));
REQUIRE(Fix, copy_arrays, void (Fix::*)(int, int, int));
REQUIRE(Fix, pack_exchange, int (Fix::*)(int, double *));
REQUIRE(Fix, unpack_exchange, int (Fix::*)(int, double *));
REQUIRE(Fix, set_molecule, void (Fix::*)(int, tagint, int, double *, double *, double *));

REQUIRE(FixNeighHistory, firstflag, int **FixNeighHistory::*);
REQUIRE(FixNeighHistory, firstvalue, double **FixNeighHistory::*);
REQUIRE(FixNeighHistory, pair, Pair *FixNeighHistory::*);
REQUIRE(FixNeighHistory, pre_exchange, void (FixNeighHistory::*)());
REQUIRE(FixNeighHistory, post_run, void (FixNeighHistory::*)());
REQUIRE(FixNeighHistory, write_restart, void (FixNeighHistory::*)(FILE *));
REQUIRE(FixNeighHistory, pack_reverse_comm, int (FixNeighHistory::*)(int, int, double *));
REQUIRE(FixNeighHistory, unpack_reverse_comm, void (FixNeighHistory::*)(int, int *, double *));

REQUIRE(NeighList, inum, int NeighList::*);
REQUIRE(NeighList, ilist, int *NeighList::*);
REQUIRE(NeighList, numneigh, int *NeighList::*);
REQUIRE(NeighList, firstneigh, int **NeighList::*);

REQUIRE(Force, pair_map, Force::PairCreatorMap *Force::*);
REQUIRE(Force, newton_pair, int Force::*);
REQUIRE(Modify, fix_map, Modify::FixCreatorMap *Modify::*);
REQUIRE(Comm, me, int Comm::*);
REQUIRE(Comm, style, int Comm::*);
REQUIRE(Update, dt, double Update::*);
REQUIRE(Update, ntimestep, bigint Update::*);
