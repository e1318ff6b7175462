// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// LAMMPS' neighbour history, right in restart files that `write_restart` makes between runs, where atoms get other IDs between
/// runs, and under `comm_style tiled`.

#ifndef ELLGRAN_HISTORY_H
#define ELLGRAN_HISTORY_H

#include "fix_neigh_history.h"

#include "ellgran_substitute.h"

#include <functional>
#include <string>

namespace LAMMPS_NS {

/// Stops with a message that begins with `caller` if what the restart file holds of the atom with ID `of_file` is given to the local atom `i`
/// that is another one: LAMMPS does not move it with the atoms until the first run.
void require_atom_of_file(class LAMMPS *lmp, const std::string &caller, int i, tagint of_file);

/// When a run ends, history moves from the neighbour list to the atoms. `write_restart` then moves atoms between
/// processors and renumbers ghosts, so that the list of the last run points to other atoms, and the base class
/// reads it all the same: contacts across processors and periodic boundaries are lost or mixed up. Here the
/// list is read only while a run goes on.
///
/// With `newton on` a contact across processors is in the list of one of them and must be told to the other. The base
/// class does so by a message of variable size, which `comm_style tiled` does not have: here it is told in rounds of one
/// contact a ghost.
///
/// `delete_atoms` gives all atoms other IDs, if it is not told `compress no`, and contacts are remembered by ID. Each atom keeps the
/// ID that it had when the last run ended; where another run finds other ones, what is remembered is renumbered. So it does with its type:
/// under the law of another one, what its contacts remember may mean something else. Restart files have the type too.
class FixEllgranHistory : public FixNeighHistory {
 public:
  FixEllgranHistory(class LAMMPS *, int, char **);
  ~FixEllgranHistory() override;

  // Brings firstflag and firstvalue up to date.
  std::function<void()> before_reading;
  // Whether contacts remember what must not be mixed up with that of others.
  bool tells_contacts_apart;

  // Whether contacts of an atom that had the first type and now has the second remember something else; empty: none do, whatever the types.
  std::function<bool(int, int)> means_something_else;
  [[nodiscard]] bool types_have_changed() const;

  // Between two runs: no contact remembers anything any more.
  virtual void forget();

  void init() override;
  void pre_exchange() override;
  void post_neighbor() override;
  void setup(int) override;
  void min_setup(int) override;
  void post_run() override;
  void write_restart(FILE *) override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;

 protected:
  bool list_is_current;
  tagint *ids_at_end;    // of each atom when the last run ended; 0: not known, as after a restart
  int *types_at_end;     // the same; after a restart that of the file, 0 if it has none

  void remember_atoms();

 private:
  static constexpr tagint NEW_ATOM = -1;
  int room_for_ids;
  int round;    // of messages under `comm_style tiled`, -1: the base class' messages

  void pre_exchange_newton() override;
  void refuse_second_contacts() const;
  void follow_new_ids();
  void follow_new_types();
  [[nodiscard]] bool is_of_other_type(int i) const;

  // Room for the history of one more contact of atom i.
  double *add_partner(int i, tagint partner_id);
};

/// Replaces the fix `old_id` by one with `id` that keeps `length` doubles per neighbour, in the same place.
template <class History = FixEllgranHistory>
History *replace_by_history(Modify *modify, const std::string &old_id, const std::string &id, int length)
{
  const SubstituteFix<History> substitute(modify, "NEIGH_HISTORY");
  const std::string command = id + " all NEIGH_HISTORY " + std::to_string(length);
  return static_cast<History *>(modify->replace_fix(old_id, command, 0));
}

}    // namespace LAMMPS_NS

#endif
