/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Viscosities per type: fix ID all property/global viscosityShear|viscosityBulk peratomtype ... */

#include <cstdio>

#include "error.h"
#include "fix_property_global.h"
#include "property_registry.h"

namespace MODEL_PARAMS {

static VectorProperty *create(PropertyRegistry &registry, const char *caller, const char *name)
{
  const int types = registry.max_type();
  FixPropertyGlobal *values = registry.getGlobalProperty(name, "property/global", "peratomtype", types, 0, caller);
  VectorProperty *vector = new VectorProperty(types + 1);
  for (int k = 1; k <= types; k++) {
    const double value = values->compute_vector(k - 1);
    if (!(value >= 0.0)) {
      char message[200];
      snprintf(message, sizeof(message), "%s: %s of type %d is %g and must be at least 0", caller, name, k, value);
      registry.getLAMMPS()->error->all(FLERR, message);
    }
    vector->data[k] = value;
  }
  return vector;
}

VectorProperty *createViscosityShear(PropertyRegistry &registry, const char *caller, bool)
{
  return create(registry, caller, "viscosityShear");
}

VectorProperty *createViscosityBulk(PropertyRegistry &registry, const char *caller, bool)
{
  return create(registry, caller, "viscosityBulk");
}

}
