// SPDX-License-Identifier: MIT OR Apache-2.0
// The same overlap from C++.
#include <ellgran.h>

#include <iostream>

int main()
{
  EllgranBody i = ELLGRAN_INIT(EllgranBody), j;
  i.quaternion[0] = i.semi_axes[0] = i.semi_axes[1] = i.semi_axes[2] = 1;
  i.mass = 1;
  i.particle_type = 1;
  i.identifier = 1;
  j = i;
  j.position[0] = 1.5;
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  if (ellgran_contact_geometry(nullptr, &i, &j, nullptr, &geometry) != ELLGRAN_SUCCESS) {
    std::cerr << ellgran_last_error() << '\n';
    return 1;
  }
  std::cout << "ellgran " << ellgran_version() << ": " << geometry.touching << " " << geometry.penetration << '\n';
}
