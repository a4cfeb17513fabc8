#include "sort_last/icet_communicator.hpp"

#include <memory>
#include <vector>

#include "simulate/charge.hpp"

namespace ringsplat::sort_last {
namespace {

/// What IceT passes as `out` of a gathering when the part is in its place already (its
/// IceTDevCommunication.h, which is not installed).
bool is_in_place(const void* out) { return reinterpret_cast<std::intptr_t>(out) == -1; }

struct Data {
  MPI_Comm comm;
  Traffic* traffic;
};

Data& data_of(IceTCommunicator self) { return *static_cast<Data*>(self->data); }

/// Sets IceT's current context again when this call is over: another simulated rank may have run meanwhile.
class KeptContext {
 public:
  KeptContext() : context_(icetGetContext()) {}
  ~KeptContext() { icetSetContext(context_); }
  KeptContext(const KeptContext&) = delete;
  KeptContext& operator=(const KeptContext&) = delete;

 private:
  IceTContext context_;
};

int size_of(IceTEnum type) {
  switch (type) {
    case ICET_BOOLEAN:
    case ICET_BYTE:
      return 1;
    case ICET_SHORT:
      return 2;
    case ICET_INT:
    case ICET_FLOAT:
      return 4;
    case ICET_DOUBLE:
      return 8;
    default:
      MPI_Abort(MPI_COMM_WORLD, 3);
      return 1;
  }
}

int bytes_of(int count, IceTEnum type) { return count * size_of(type); }

void note_sent(Data& data, int count, IceTEnum type) {
  data.traffic->messages += 1;
  data.traffic->bytes +=
      std::uint64_t(count) * std::uint64_t(size_of(type)) * std::uint64_t(data.traffic->weight);
  charge(data.traffic->send);
}

void charge_received(const Data& data, double bytes) {
  charge(data.traffic->receive + data.traffic->seconds_per_byte * data.traffic->weight * bytes);
}

void charge_received(const Data& data, MPI_Status& status) {
  int bytes = 0;
  MPI_Get_count(&status, MPI_BYTE, &bytes);
  charge_received(data, bytes);
}

IceTCommunicator with_data(const Data& data);

IceTCommunicator duplicate(IceTCommunicator self) { return with_data(data_of(self)); }

void destroy(IceTCommunicator self) { destroy_icet_communicator(self); }

IceTCommunicator subset(IceTCommunicator self, int count, const IceTInt32* ranks) {
  const KeptContext kept;
  Data data = data_of(self);
  MPI_Group all, some;
  MPI_Comm_group(data.comm, &all);
  MPI_Group_incl(all, count, ranks, &some);
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_create(data.comm, some, &part);
  MPI_Group_free(&some);
  MPI_Group_free(&all);
  if (part == MPI_COMM_NULL) return ICET_COMM_NULL;
  data.comm = part;
  return with_data(data);
}

void barrier(IceTCommunicator self) {
  const KeptContext kept;
  MPI_Barrier(data_of(self).comm);
}

void send(IceTCommunicator self, const void* buffer, int count, IceTEnum type, int to, int tag) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  MPI_Send(buffer, bytes, MPI_BYTE, to, tag, data.comm);
}

void receive(IceTCommunicator self, void* buffer, int count, IceTEnum type, int from, int tag) {
  const KeptContext kept;
  Data& data = data_of(self);
  const int bytes = bytes_of(count, type);
  MPI_Status status;
  MPI_Recv(buffer, bytes, MPI_BYTE, from, tag, data.comm, &status);
  charge_received(data, status);
}

void send_receive(IceTCommunicator self, const void* out, int out_count, IceTEnum out_type, int to,
                  int out_tag, void* in, int in_count, IceTEnum in_type, int from, int in_tag) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, out_count, out_type);
  MPI_Status status;
  MPI_Sendrecv(out, bytes_of(out_count, out_type), MPI_BYTE, to, out_tag, in, bytes_of(in_count, in_type),
               MPI_BYTE, from, in_tag, data.comm, &status);
  charge_received(data, status);
}

void gather(IceTCommunicator self, const void* out, int count, IceTEnum type, void* in, int root) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  MPI_Gather(is_in_place(out) ? MPI_IN_PLACE : out, bytes, MPI_BYTE, in, bytes, MPI_BYTE, root, data.comm);
}

void gather_parts(IceTCommunicator self, const void* out, int count, IceTEnum type, void* in,
                  const int* counts, const int* offsets, int root) {
  const KeptContext kept;
  Data& data = data_of(self);
  int rank = 0, ranks = 0;
  MPI_Comm_rank(data.comm, &rank);
  MPI_Comm_size(data.comm, &ranks);
  if (rank != root) note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  std::vector<int> byte_counts, byte_offsets;
  double others = 0;
  for (int k = 0; rank == root && k < ranks; ++k) {
    byte_counts.push_back(bytes_of(counts[k], type));
    byte_offsets.push_back(bytes_of(offsets[k], type));
    if (k != root) others += byte_counts.back();
  }
  MPI_Gatherv(is_in_place(out) ? MPI_IN_PLACE : out, bytes, MPI_BYTE, in, byte_counts.data(),
              byte_offsets.data(), MPI_BYTE, root, data.comm);
  if (rank == root) charge_received(data, others);
}

void gather_for_all(IceTCommunicator self, const void* out, int count, IceTEnum type, void* in) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  MPI_Allgather(is_in_place(out) ? MPI_IN_PLACE : out, bytes, MPI_BYTE, in, bytes, MPI_BYTE, data.comm);
}

void all_to_all(IceTCommunicator self, const void* out, int count, IceTEnum type, void* in) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  MPI_Alltoall(out, bytes, MPI_BYTE, in, bytes, MPI_BYTE, data.comm);
}

struct Request {
  MPI_Request request = MPI_REQUEST_NULL;
  bool receives = false;
};

IceTCommRequest with_request(const Request& request) {
  return new IceTCommRequestStruct{ICET_NULL, new Request(request)};
}
Request& request_of(IceTCommRequest request) { return *static_cast<Request*>(request->internals); }
void forget(IceTCommRequest& request) {
  delete &request_of(request);
  delete request;
  request = ICET_COMM_REQUEST_NULL;
}

IceTCommRequest begin_send(IceTCommunicator self, const void* buffer, int count, IceTEnum type, int to,
                           int tag) {
  const KeptContext kept;
  Data& data = data_of(self);
  note_sent(data, count, type);
  const int bytes = bytes_of(count, type);
  Request request;
  MPI_Isend(buffer, bytes, MPI_BYTE, to, tag, data.comm, &request.request);
  return with_request(request);
}

IceTCommRequest begin_receive(IceTCommunicator self, void* buffer, int count, IceTEnum type, int from,
                              int tag) {
  const KeptContext kept;
  Data& data = data_of(self);
  const int bytes = bytes_of(count, type);
  Request request{.receives = true};
  MPI_Irecv(buffer, bytes, MPI_BYTE, from, tag, data.comm, &request.request);
  return with_request(request);
}

void wait(IceTCommunicator self, IceTCommRequest* request) {
  if (*request == ICET_COMM_REQUEST_NULL) return;
  const KeptContext kept;
  MPI_Status status;
  MPI_Wait(&request_of(*request).request, &status);
  if (request_of(*request).receives) charge_received(data_of(self), status);
  forget(*request);
}

/// SMPI's MPI_Waitany does not take null requests.
int wait_for_any(IceTCommunicator self, int count, IceTCommRequest* requests) {
  const KeptContext kept;
  std::vector<int> places;
  std::vector<MPI_Request> active;
  for (int k = 0; k < count; ++k)
    if (requests[k] != ICET_COMM_REQUEST_NULL) {
      places.push_back(k);
      active.push_back(request_of(requests[k]).request);
    }
  if (active.empty()) return -1;
  int done = 0;
  MPI_Status status;
  MPI_Waitany(int(active.size()), active.data(), &done, &status);
  const int place = places[std::size_t(done)];
  if (request_of(requests[place]).receives) charge_received(data_of(self), status);
  forget(requests[place]);
  return place;
}

int size(IceTCommunicator self) {
  int ranks = 0;
  MPI_Comm_size(data_of(self).comm, &ranks);
  return ranks;
}

int rank(IceTCommunicator self) {
  int rank = 0;
  MPI_Comm_rank(data_of(self).comm, &rank);
  return rank;
}

IceTCommunicator with_data(const Data& data) {
  return new IceTCommunicatorStruct{.Duplicate = duplicate,
                                    .Destroy = destroy,
                                    .Subset = subset,
                                    .Barrier = barrier,
                                    .Send = send,
                                    .Recv = receive,
                                    .Sendrecv = send_receive,
                                    .Gather = gather,
                                    .Gatherv = gather_parts,
                                    .Allgather = gather_for_all,
                                    .Alltoall = all_to_all,
                                    .Isend = begin_send,
                                    .Irecv = begin_receive,
                                    .Wait = wait,
                                    .Waitany = wait_for_any,
                                    .Comm_size = size,
                                    .Comm_rank = rank,
                                    .data = new Data(data)};
}

}  // namespace

IceTCommunicator make_icet_communicator(MPI_Comm comm, Traffic& traffic) {
  return with_data({comm, &traffic});
}

void destroy_icet_communicator(IceTCommunicator communicator) {
  delete static_cast<Data*>(communicator->data);
  delete communicator;
}

}  // namespace ringsplat::sort_last
