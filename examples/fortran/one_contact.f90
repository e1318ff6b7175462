! SPDX-License-Identifier: MIT OR Apache-2.0
!
! The force of one contact: two ellipsoids that overlap by 10 micrometres and approach. As examples/c/one_contact.c.
!
!   gfortran one_contact.f90 $(pkg-config --libs ellgran)
!
! Prints: normal force 10.5319 mN
!
! The types below are the structs of ellgran.h, field by field. Each begins with its size; the rest starts at zero.
program one_contact
  use, intrinsic :: iso_c_binding
  implicit none

  type, bind(c) :: law_parameters
    integer(c_size_t) :: size = 0
    integer(c_int32_t) :: choices(9) = 0   ! normal, damping, tangential and so on
    real(c_double) :: constants(11) = 0    ! youngs_modulus and so on
  end type

  type, bind(c) :: body
    integer(c_size_t) :: size = 0
    real(c_double) :: position(3) = 0, quaternion(4) = [1, 0, 0, 0], semi_axes(3) = 0
    real(c_double) :: velocity(3) = 0, angular_velocity(3) = 0, mass = 0
    integer(c_int32_t) :: kind = 1         ! its type in the laws
    integer(c_int64_t) :: identifier = 0
  end type

  type, bind(c) :: time_step
    integer(c_size_t) :: size = 0
    integer(c_int32_t) :: advance_history = 1
    real(c_double) :: time_step = 0
  end type

  type, bind(c) :: contact_force
    integer(c_size_t) :: size = 0
    real(c_double) :: force(3) = 0, torque_i(3) = 0, torque_j(3) = 0, normal_force = 0
    real(c_double) :: tangential_force(3) = 0, displacement(3) = 0, penetration_rate = 0
    real(c_double) :: elastic_energy = 0, tangential_energy = 0, viscous_force(3) = 0, frictional_force(3) = 0
    real(c_double) :: viscous_power = 0, tangential_power = 0, contact_semi_axes(2) = 0
  end type

  interface
    integer(c_int32_t) function law_parameters_parse(count, words, consumed, parameters) &
        bind(c, name="ellgran_law_parameters_parse")
      import
      integer(c_size_t), value :: count
      type(c_ptr), intent(in) :: words(*)
      type(c_ptr), value :: consumed
      type(law_parameters), intent(inout) :: parameters
    end function
    integer(c_int32_t) function laws_new(type_count, parameters, is_set, options, laws) bind(c, name="ellgran_laws_new")
      import
      integer(c_int32_t), value :: type_count, options
      type(law_parameters), intent(in) :: parameters(*)
      integer(c_int8_t), intent(in) :: is_set(*)
      type(c_ptr), intent(out) :: laws
    end function
    subroutine laws_free(laws) bind(c, name="ellgran_laws_free")
      import
      type(c_ptr), value :: laws
    end subroutine
    integer(c_int32_t) function contact(laws, i, j, step, touching, history, geometry, force) &
        bind(c, name="ellgran_contact")
      import
      type(c_ptr), value :: laws, geometry
      type(body), intent(in) :: i, j
      type(time_step), intent(in) :: step
      integer(c_int32_t), intent(inout) :: touching
      real(c_double), intent(inout) :: history(*)
      type(contact_force), intent(inout) :: force
    end function
    function last_error() bind(c, name="ellgran_last_error") result(message)
      import
      type(c_ptr) :: message
    end function
  end interface

  ! The words of a deck, each ended as C ends strings.
  character(kind=c_char, len=11), target :: words(8) = [character(kind=c_char, len=11) :: &
      "nfd", "1e7", "0.3", "200", "200", "tangential", "tfd", "0.5"]
  type(c_ptr) :: addresses(8), laws
  type(law_parameters) :: parameters(1)
  type(body) :: i, j
  type(time_step) :: step
  type(contact_force) :: force
  integer(c_int32_t) :: touching = 0
  real(c_double) :: history(8) = 0         ! ellgran_laws_history_length(laws) for each contact
  integer :: k

  do k = 1, 8
    words(k) = trim(words(k)) // c_null_char
    addresses(k) = c_loc(words(k))
  end do
  parameters%size = c_sizeof(parameters(1))
  call check(law_parameters_parse(8_c_size_t, addresses, c_null_ptr, parameters(1)))
  call check(laws_new(1_c_int32_t, parameters, [1_c_int8_t], 0_c_int32_t, laws))

  i%size = c_sizeof(i)
  i%semi_axes = [2e-3_c_double, 1e-3_c_double, 1e-3_c_double]
  i%mass = 1e-5_c_double
  j = i
  j%position(3) = 1.99e-3_c_double
  j%velocity(3) = -0.1_c_double
  step%size = c_sizeof(step)
  step%time_step = 1e-6_c_double
  force%size = c_sizeof(force)
  call check(contact(laws, i, j, step, touching, history, c_null_ptr, force))
  print "('normal force ', f0.4, ' mN')", 1e3_c_double * force%normal_force
  call laws_free(laws)

contains

  !> Stops with the library's message where a call failed.
  subroutine check(status)
    integer(c_int32_t), intent(in) :: status
    character(kind=c_char), pointer :: message(:)
    integer :: length
    if (status == 0) return
    call c_f_pointer(last_error(), message, [1000])
    length = 0
    do while (message(length + 1) /= c_null_char)
      length = length + 1
    end do
    print "(*(a))", message(:length)
    error stop 1
  end subroutine

end program one_contact
