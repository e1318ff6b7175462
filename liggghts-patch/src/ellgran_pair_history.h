/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * LIGGGHTS' fix contacthistory, which remembers the contacts of pairs by the ID of the other particle, right where particles are deleted
 * or copied, or get other IDs.
 *
 * 'delete_atoms' gives all particles other IDs, if it is not told 'compress no', and so does 'fix insert/... compress_tags yes' while a
 * run goes on. Here each particle keeps the ID under which others remember it; before a neighbour list is built with another one, what
 * is remembered is renumbered.
 *
 * After 'replicate', copies are remembered under the IDs of their originals. What is remembered of an ID that several have then goes on with the nearest
 * of them, across a periodic boundary too.
 *
 * 'delete_atoms' also reads the list of the last run each time, whose places are those of other particles after an earlier
 * 'delete_atoms', a 'replicate' or a 'write_restart'. Here it is read once, when a run ends.
 */

#ifndef ELLGRAN_PAIR_HISTORY_H
#define ELLGRAN_PAIR_HISTORY_H

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "fix_contact_history.h"

namespace LAMMPS_NS {

class PairGran;

class EllgranPairHistory : public FixContactHistory {
 public:
  // Puts one in the place of the fix that the pair style made, with all that it holds. Call it when a run begins, before fixes are
  // initialised.
  static void replace(class LAMMPS *lmp, PairGran *pair);
  virtual ~EllgranPairHistory();

  // Names of the values that contacts of pairs remember, by the contact models; empty if none do.
  static std::string names_of_values(class Modify *modify);

  virtual int setmask();
  virtual void setup_pre_exchange();
  virtual void setup_pre_neighbor();
  virtual void pre_exchange();
  virtual void pre_neighbor();
  virtual void post_run();

  virtual double memory_usage();
  virtual void grow_arrays(int count);
  virtual void copy_arrays(int from, int to, int deleted);
  virtual void set_arrays(int particle);
  virtual int pack_exchange(int particle, double *buffer);
  virtual int unpack_exchange(int particle, double *buffer);
  virtual void write_restart(FILE *fp);
  virtual void unpack_restart(int particle, int place);

 protected:
  virtual void allocate_pages();

 private:
  struct Candidate {
    int id;
    double position[3];
  };
  typedef std::map<int, std::vector<Candidate> > Candidates;  // by the ID under which they are remembered

  bool has_run_;
  int *ids_;  // under which each particle is remembered; 0: it is new, and no other particle remembers it

  EllgranPairHistory(class LAMMPS *, int, char **);
  void take(FixContactHistory *other);
  void follow_new_ids();
  void find_candidates(const std::map<int, int> &renumbered, Candidates &candidates);
  int nearest(const std::vector<Candidate> &candidates, const double *position);
  void own_histories();
  void refuse_ids_twice();
};

}

#endif
