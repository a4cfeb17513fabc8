! Ringsplat in Fortran: ringsplat/ringsplat.h with Fortran's texts and arrays. Compile this file with your program
! and link it with libringsplat.
!
!     type(c_ptr) :: session
!     integer :: status
!     status = ringsplat_open(MPI_COMM_WORLD, session)             ! of mpi_f08: MPI_COMM_WORLD%MPI_VAL
!     status = ringsplat_set_grid(session, [nx, ny, nz], 'float32')
!     status = ringsplat_add_block(session, first, values(1:mx, 1:my, 1:mz))   ! without ghosts; not copied
!     status = ringsplat_commit(session)
!     status = ringsplat_render(session, '--tf=mr-soft --azimuth=30', 'picture.png')
!     call ringsplat_close(session)
!
! Functions return 0, or ringsplat_input_error or ringsplat_run_error; ringsplat_message() then says what is wrong.
! Places count from 0, as in C.
module ringsplat
  use, intrinsic :: iso_c_binding
  implicit none
  private
  public :: ringsplat_open, ringsplat_close, ringsplat_set_grid, ringsplat_add_block, ringsplat_update_block
  public :: ringsplat_commit, ringsplat_render, ringsplat_act, ringsplat_serve, ringsplat_url, ringsplat_offer, ringsplat_show
  public :: ringsplat_message, ringsplat_open_aside, ringsplat_visualise

  integer, parameter, public :: ringsplat_input_error = 2, ringsplat_run_error = 3, ringsplat_alone = -1

  interface
    integer(c_int) function ringsplat_open(communicator, session) bind(C)
      import
      integer(c_int), value :: communicator
      type(c_ptr), intent(out) :: session
    end function
    integer(c_int) function ringsplat_open_aside(communicator, visualisation_ranks, session) bind(C)
      import
      integer(c_int), value :: communicator, visualisation_ranks
      type(c_ptr), intent(out) :: session
    end function
    integer(c_int) function ringsplat_visualise(session) bind(C)
      import
      type(c_ptr), value :: session
    end function
    subroutine ringsplat_close(session) bind(C)
      import
      type(c_ptr), value :: session
    end subroutine
    integer(c_int) function ringsplat_commit(session) bind(C)
      import
      type(c_ptr), value :: session
    end function
    integer(c_int) function ringsplat_show(session, step, time) bind(C)
      import
      type(c_ptr), value :: session
      integer(c_int64_t), value :: step
      real(c_double), value :: time
    end function
    integer(c_int) function c_set_grid(session, dims, type, spacing, origin) bind(C, name='ringsplat_set_grid')
      import
      type(c_ptr), value :: session
      integer(c_int32_t), intent(in) :: dims(3)
      character(kind=c_char), intent(in) :: type(*)
      real(c_double), intent(in), optional :: spacing(3), origin(3)
    end function
    integer(c_int) function c_add_block(session, first, end, voxel, strides) bind(C, name='ringsplat_add_block')
      import
      type(c_ptr), value :: session, voxel
      integer(c_int32_t), intent(in) :: first(3), end(3)
      integer(c_int64_t), intent(in) :: strides(3)
    end function
    integer(c_int) function c_update_block(session, block, voxel, strides) bind(C, name='ringsplat_update_block')
      import
      type(c_ptr), value :: session, voxel
      integer(c_int), value :: block
      integer(c_int64_t), intent(in) :: strides(3)
    end function
    integer(c_int) function c_render(session, options, file) bind(C, name='ringsplat_render')
      import
      type(c_ptr), value :: session
      character(kind=c_char), intent(in) :: options(*), file(*)
    end function
    integer(c_int) function c_act(session, file, step) bind(C, name='ringsplat_act')
      import
      type(c_ptr), value :: session
      character(kind=c_char), intent(in) :: file(*)
      integer(c_int64_t), value :: step
    end function
    integer(c_int) function c_serve(session, options, port, share) bind(C, name='ringsplat_serve')
      import
      type(c_ptr), value :: session
      character(kind=c_char), intent(in) :: options(*)
      integer(c_int), value :: port
      real(c_double), value :: share
    end function
    integer(c_int) function c_offer(session, name, number, low, high) bind(C, name='ringsplat_offer')
      import
      type(c_ptr), value :: session, number
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), value :: low, high
    end function
    type(c_ptr) function c_message() bind(C, name='ringsplat_message')
      import
    end function
    type(c_ptr) function c_url(session) bind(C, name='ringsplat_url')
      import
      type(c_ptr), value :: session
    end function
  end interface

contains

  integer function ringsplat_set_grid(session, dims, type, spacing, origin) result(status)
    type(c_ptr), intent(in) :: session
    integer, intent(in) :: dims(3)
    character(*), intent(in) :: type
    real(c_double), intent(in), optional :: spacing(3), origin(3)
    status = c_set_grid(session, int(dims, c_int32_t), trim(type) // c_null_char, spacing, origin)
  end function

  ! `values`: any section of an array of real(c_float), real(c_double) or an integer type; an empty one is left out.
  integer function ringsplat_add_block(session, first, values) result(status)
    type(c_ptr), intent(in) :: session
    integer, intent(in) :: first(3)
    class(*), intent(in), target :: values(:, :, :)
    type(c_ptr) :: at(4)
    status = 0
    if (size(values) == 0) return
    at = places(values)
    status = c_add_block(session, int(first, c_int32_t), int(first + shape(values), c_int32_t), at(1), strides(at))
  end function

  integer function ringsplat_update_block(session, block, values) result(status)
    type(c_ptr), intent(in) :: session
    integer, intent(in) :: block
    class(*), intent(in), target :: values(:, :, :)
    type(c_ptr) :: at(4)
    status = 0
    if (size(values) == 0) return
    at = places(values)
    status = c_update_block(session, int(block, c_int), at(1), strides(at))
  end function

  integer function ringsplat_render(session, options, file) result(status)
    type(c_ptr), intent(in) :: session
    character(*), intent(in) :: options, file
    status = c_render(session, options // c_null_char, trim(file) // c_null_char)
  end function

  integer function ringsplat_act(session, file, step) result(status)
    type(c_ptr), intent(in) :: session
    character(*), intent(in) :: file
    integer(c_int64_t), intent(in) :: step
    status = c_act(session, trim(file) // c_null_char, step)
  end function

  integer function ringsplat_serve(session, options, port, share) result(status)
    type(c_ptr), intent(in) :: session
    character(*), intent(in) :: options
    integer, intent(in) :: port
    real(c_double), intent(in) :: share
    status = c_serve(session, options // c_null_char, int(port, c_int), share)
  end function

  integer function ringsplat_offer(session, name, number, low, high) result(status)
    type(c_ptr), intent(in) :: session
    character(*), intent(in) :: name
    real(c_double), intent(in), target :: number
    real(c_double), intent(in) :: low, high
    status = c_offer(session, trim(name) // c_null_char, c_loc(number), low, high)
  end function

  function ringsplat_message() result(text)
    character(:), allocatable :: text
    text = text_at(c_message())
  end function

  function ringsplat_url(session) result(text)
    type(c_ptr), intent(in) :: session
    character(:), allocatable :: text
    text = text_at(c_url(session))
  end function

  function text_at(address) result(text)
    type(c_ptr), intent(in) :: address
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: k
    call c_f_pointer(address, letters, [huge(k)])
    text = ''
    do k = 1, huge(k) - 1
      if (letters(k) == c_null_char) return
      text = text // letters(k)
    end do
  end function

  ! Where the first value lies, and its neighbours, or itself where it has none.
  function places(values) result(at)
    class(*), intent(in), target :: values(:, :, :)
    type(c_ptr) :: at(4)
    integer :: x(4), y(4), z(4), k
    x = [1, min(2, size(values, 1)), 1, 1]
    y = [1, 1, min(2, size(values, 2)), 1]
    z = [1, 1, 1, min(2, size(values, 3))]
    do k = 1, 4
      select type (values)
      type is (real(c_float)); at(k) = c_loc(values(x(k), y(k), z(k)))
      type is (real(c_double)); at(k) = c_loc(values(x(k), y(k), z(k)))
      type is (integer(c_int8_t)); at(k) = c_loc(values(x(k), y(k), z(k)))
      type is (integer(c_int16_t)); at(k) = c_loc(values(x(k), y(k), z(k)))
      type is (integer(c_int32_t)); at(k) = c_loc(values(x(k), y(k), z(k)))
      class default; error stop 'ringsplat: blocks are arrays of reals or integers'
      end select
    end do
  end function

  function strides(at) result(bytes)
    type(c_ptr), intent(in) :: at(4)
    integer(c_int64_t) :: bytes(3)
    integer :: k
    do k = 1, 3
      bytes(k) = transfer(at(k + 1), bytes(k)) - transfer(at(1), bytes(k))
    end do
  end function
end module
