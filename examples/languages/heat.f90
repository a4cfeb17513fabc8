! The heat equation on slabs of a cube, drawn and shown by Ringsplat from Fortran:
!
!     mpirun -n 3 heat_f PICTURE [STEPS [PICTURES.toml]]
!
! It prints a page's address, on which the run can be watched and the heating changed. A file may ask for more
! pictures while it runs.
program heat
  use, intrinsic :: iso_c_binding
  use mpi
  use ringsplat
  implicit none
  integer, parameter :: cells = 32
  real(c_float), allocatable :: t(:, :, :), next(:, :, :)
  real(c_double), target :: heating = 0.1d0
  type(c_ptr) :: session
  integer :: rank, ranks, first, depth, before, after, steps, k, error
  character(256) :: word, picture, pictures

  call MPI_Init(error)
  call MPI_Comm_rank(MPI_COMM_WORLD, rank, error)
  call MPI_Comm_size(MPI_COMM_WORLD, ranks, error)
  first = cells * rank / ranks
  depth = cells * (rank + 1) / ranks - first
  before = merge(rank - 1, MPI_PROC_NULL, rank > 0)
  after = merge(rank + 1, MPI_PROC_NULL, rank + 1 < ranks)
  allocate (t(0:cells + 1, 0:cells + 1, 0:depth + 1), source=0.0)
  allocate (next, source=t)

  call check(ringsplat_open(MPI_COMM_WORLD, session))
  call check(ringsplat_set_grid(session, [cells, cells, cells], 'float32'))
  call check(ringsplat_add_block(session, [0, 0, first], t(1:cells, 1:cells, 1:depth)))
  call check(ringsplat_commit(session))
  call check(ringsplat_serve(session, '--tf=grey --range=0:2', 0, 0.05d0))
  call check(ringsplat_offer(session, 'heating', heating, 0d0, 1d0))
  if (rank == 0) print '(a)', ringsplat_url(session)

  steps = 100
  call get_command_argument(1, picture)
  call get_command_argument(2, word)
  if (word /= '') read (word, *) steps
  call get_command_argument(3, pictures)
  do k = 1, steps
    call exchange()
    call step(real(heating, c_float))
    t = next
    call check(ringsplat_show(session, int(k, c_int64_t), 0.125d0 * k))
    if (pictures /= '') call check(ringsplat_act(session, pictures, int(k, c_int64_t)))
  end do
  call check(ringsplat_commit(session))
  if (picture /= '') call check(ringsplat_render(session, '--tf=grey --range=0:2 --size=256 --background=black', picture))
  call ringsplat_close(session)
  deallocate (t, next)
  call MPI_Finalize(error)

contains

  subroutine check(status)
    integer, intent(in) :: status
    if (status == 0) return
    print '(a)', 'heat: ' // ringsplat_message()
    call MPI_Abort(MPI_COMM_WORLD, status, error)
  end subroutine

  ! Planes 0 and depth + 1 are the neighbours'; outside the cube all is cold.
  subroutine exchange()
    integer :: n
    n = size(t, 1) * size(t, 2)
    call MPI_Sendrecv(t(0, 0, 1), n, MPI_REAL, before, 0, t(0, 0, depth + 1), n, MPI_REAL, after, 0, &
                      MPI_COMM_WORLD, MPI_STATUS_IGNORE, error)
    call MPI_Sendrecv(t(0, 0, depth), n, MPI_REAL, after, 1, t(0, 0, 0), n, MPI_REAL, before, 1, &
                      MPI_COMM_WORLD, MPI_STATUS_IGNORE, error)
  end subroutine

  subroutine step(heats)
    real(c_float), intent(in) :: heats
    real(c_float) :: around
    integer :: x, y, z
    do z = 1, depth
      do y = 1, cells
        do x = 1, cells
          around = t(x - 1, y, z) + t(x + 1, y, z) + t(x, y - 1, z) + t(x, y + 1, z) + t(x, y, z - 1) + t(x, y, z + 1)
          next(x, y, z) = t(x, y, z) + (around - 6 * t(x, y, z)) / 8
          if (abs(first + z - cells / 2) < 3 .and. abs(y - cells / 3) < 3 .and. abs(x - cells / 2) < 3) &
            next(x, y, z) = next(x, y, z) + heats
        end do
      end do
    end do
  end subroutine
end program
