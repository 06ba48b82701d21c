//! The manifest of a Kubernetes Job.

use super::task::{GRACE, HandOver, Tasks, index, limited, title};

/// Separates two lines of the container's script in the manifest. It is a line break, followed by the indentation of
/// the next line.
const DEEP: &str = "\n              ";

pub(super) fn manifest(hand_over: &HandOver, tasks: &Tasks) -> String {
    // Kubernetes reads `$$` as a dollar sign, and `$(NAME)` as a variable of the container.
    let escaped = &Tasks {
        sweep: tasks.sweep.replace('$', "$$"),
        ..tasks.clone()
    };
    let (title, index, command) = (
        title(hand_over, tasks),
        index(hand_over).trim_end().replace('\n', DEEP),
        limited(hand_over, escaped),
    );
    let Tasks {
        count, sweep, name, ..
    } = tasks;
    let in_container = &escaped.sweep;
    let (ranges, cores) = (tasks.ranges().join(" "), hand_over.cores);
    let at_once = hand_over.throttle.map_or(*count, |throttle| throttle.get());
    let version = env!("CARGO_PKG_VERSION");
    format!(
        r#"{title}#
# Edit `image`, which must have `cosmic` and a shell, and `claimName`, the volume with the sweep. The sweep's
# folder is {sweep}, relative to the volume's root unless the path is absolute.
# Start it with:  kubectl apply -f FILE
#
# A pod that receives a signal saves its runs and ends with exit code 75. Then another pod continues them.
apiVersion: batch/v1
kind: Job
metadata:
  name: {name}
spec:
  completionMode: Indexed
  completions: {count}
  parallelism: {at_once}
  backoffLimitPerIndex: 2
  podFailurePolicy:
    rules:
      # An interruption is not a failure.
      - action: Ignore
        onExitCodes:
          containerName: cosmic
          operator: In
          values: [75]
      - action: Ignore
        onPodConditions:
          - type: DisruptionTarget
            status: "True"
      # A wrong plan or a missing file fails every time.
      - action: FailIndex
        onExitCodes:
          containerName: cosmic
          operator: In
          values: [2, 4]
  template:
    spec:
      restartPolicy: Never
      terminationGracePeriodSeconds: {GRACE}
      containers:
        - name: cosmic
          image: cosmic:{version}
          workingDir: /sweeps
          command: ["/bin/sh", "-c"]
          args:
            - |
              # The task of this pod: the one at position JOB_COMPLETION_INDEX in the ranges.
              number=$JOB_COMPLETION_INDEX
              for range in {ranges}; do
                first=${{range%-*}}
                last=${{range#*-}}
                if [ "$number" -le "$((last - first))" ]; then break; fi
                number=$((number - (last - first + 1)))
              done
              task=$((first + number))
              {index}
              exec {command} >>{in_container}/logs/"$task".log 2>&1
          resources:
            requests:
              cpu: "{cores}"
            limits:
              cpu: "{cores}"
          volumeMounts:
            - name: sweeps
              mountPath: /sweeps
      volumes:
        - name: sweeps
          persistentVolumeClaim:
            claimName: sweeps
"#
    )
}
